/* What every estimator's compiled loop needs. The structures Model and Result, the
 * STATUS_* bits and the type `generated` are declared in front of this file. */

#include <math.h>
#include <string.h>
#include <time.h>

typedef void (*step_function)(void *self, const double *given, double *memory, double time,
                              const double *y, double *result);

static inline double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline void copy(double *to, const double *from, long long n)
{
    memcpy(to, from, (size_t)n * sizeof(double));
}

static inline double dot(const double *a, const double *b, long long n)
{
    double sum = 0;
    for (long long i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static inline int all_finite(const double *a, long long n)
{
    for (long long i = 0; i < n; i++)
        if (!isfinite(a[i])) return 0;
    return 1;
}

/* δ⁻ around f(x̃, w̃) in `reached`, P⁻, F, G; a result that is not wanted is 0. */
static void predict(const Model *m, const double *d_plus, const double *P_plus,
                    const double *x_lin, const double *w_lin, const double *dt,
                    const double *noise_scale, double *results[5])
{
    const double *arguments[] = {d_plus, P_plus, x_lin, w_lin, dt, noise_scale};
    m->predict(arguments, results, 0, 0, 0);
}

/* δ⁺, P⁺, v, S, W, e, H, L. */
static void update(const Model *m, const double *d_minus, const double *P_minus,
                   const double *x_lin, const double *y, const double *present,
                   double *results[8])
{
    const double *arguments[] = {d_minus, P_minus, x_lin, y, present};
    m->update(arguments, results, 0, 0, 0);
}

static void retract(const Model *m, const double *x, const double *delta, double *moved)
{
    const double *arguments[] = {x, delta};
    double *results[] = {moved};
    m->retract(arguments, results, 0, 0, 0);
}

/* Which rows have all readings they need, and readings with zero where there is none. */
static void mark_present(const Model *m, const double *y, double *present, double *clean)
{
    for (long long i = 0; i < m->n_y; i++) clean[i] = isfinite(y[i]) ? y[i] : 0.0;
    for (long long row = 0; row < m->n_r; row++) {
        present[row] = 1.0;
        for (long long i = 0; i < m->n_y; i++)
            if (m->row_needs[row * m->n_y + i] && !(fabs(y[i]) < m->saturation[i]))
                present[row] = 0.0;
    }
}

/* The remarks that any estimator makes on an estimate. */
static long long remarks(const Model *m, const double *mean, const double *covariance,
                         const double *y, const double *used)
{
    long long status = STATUS_NO_READING;
    for (long long row = 0; row < m->n_r; row++)
        if (used[row] != 0 && m->measured_rows[row]) status = 0;
    for (long long i = 0; i < m->n_y; i++) {
        if (isinf(y[i])) status |= STATUS_INFINITE_READING;
        if (isfinite(y[i]) && fabs(y[i]) >= m->saturation[i]) status |= STATUS_SATURATED;
    }
    double margin = 0;
    const double *arguments[] = {mean};
    double *results[] = {&margin};
    m->regularity(arguments, results, 0, 0, 0);
    if (fabs(margin) < m->regularity_limit) status |= STATUS_NEAR_SINGULAR;
    for (long long i = 0; m->reach && i < m->n_x; i++)
        if (covariance[i * (m->n_x + 1)] > m->reach[i] * m->reach[i])
            status |= STATUS_OUT_OF_REACH;
    return status;
}

static void report(const Model *m, const Result *r, double *result, double time,
                   const double *mean, const double *covariance, const double *v,
                   const double *S, const double *present, long long status)
{
    result[r->time_s] = time;
    copy(result + r->mean, mean, m->n_x);
    copy(result + r->covariance, covariance, m->n_x * m->n_x);
    for (long long row = 0; row < m->n_r; row++)
        result[r->innovation + row] = present[row] != 0 ? v[row] : NAN;
    copy(result + r->innovation_covariance, S, m->n_r * m->n_r);
    result[r->status] = (double)status;
    result[r->cost] = NAN;
}

/* The answer to a measurement that is older than the state. */
static void report_late(const Model *m, const Result *r, double *result, double time,
                        const double *mean, const double *covariance)
{
    result[r->time_s] = time;
    copy(result + r->mean, mean, m->n_x);
    copy(result + r->covariance, covariance, m->n_x * m->n_x);
    for (long long i = 0; i < m->n_r; i++) result[r->innovation + i] = NAN;
    for (long long i = 0; i < m->n_r * m->n_r; i++) result[r->innovation_covariance + i] = NAN;
    result[r->status] = STATUS_LATE;
    result[r->iterations] = 0;
    result[r->cost] = NAN;
}

/* A whole recording: the same step, n times. `memory` holds two states; returns which
 * of them is the last. */
static int batch(step_function step, void *self, double *memory[2], long long n,
                 const double *time, const double *y, long long n_y, double *results,
                 long long result_size)
{
    int at = 0;
    for (long long k = 0; k < n; k++, at = !at)
        step(self, memory[at], memory[!at], time[k], y + k * n_y, results + k * result_size);
    return at;
}
