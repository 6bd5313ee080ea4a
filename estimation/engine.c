/* What every estimator's compiled loop needs. The types `real`, `integer` and `generated`, the
 * structures Model and Result and the STATUS_* bits are declared in front of this file; a
 * form of the Kalman stage (estimation/covariance_stage.c or root_stage.c) stands behind it. */

typedef void (*step_function)(void *self, const real *given, real *memory, real time,
                              const real *y, real *result);

/* A clock that only grows, s: PEN_MHE_CLOCK names a function, PEN_MHE_HOSTED is a machine with an
 * operating system, and without either there is none, which a deadline (TIMED) does not allow. */
#if defined PEN_MHE_CLOCK
double PEN_MHE_CLOCK(void);
static inline double seconds(void) { return PEN_MHE_CLOCK(); }
#elif defined PEN_MHE_HOSTED
#include <time.h>
static inline double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
#else
#if TIMED
#error "a deadline needs a clock: -DPEN_MHE_CLOCK=name of a function double name(void) in seconds"
#endif
static inline double seconds(void) { return 0; }
#endif

/* Stamps that single precision cannot tell apart, whose origin moves, are one; s. */
#define SAME_S (sizeof(real) < sizeof(double) ? (real)1e-6 : 0)

/* From what the stage's form keeps in an array P_: one state's variance, and all of P. */
static inline real variance(const Model *m, const real *P, integer i);
static void covariance_of(const Model *m, const real *P, real *covariance);

static inline int all_finite(const real *a, integer n)
{
    for (integer i = 0; i < n; i++)
        if (!isfinite(a[i])) return 0;
    return 1;
}

/* Whether what an array P_ holds is a covariance in numbers. */
static inline int is_covariance(const Model *m, const real *P)
{
    for (integer i = 0; i < m->n_x; i++)
        if (!isfinite(variance(m, P, i))) return 0;
    return all_finite(P, m->n_P);
}

static void retract(const Model *m, const real *x, const real *delta, real *moved)
{
    const real *arguments[] = {x, delta};
    real *results[] = {moved};
    call(m, &m->retract, arguments, results);
}

/* A measurement's row, readings and inputs behind them: an input that is missing is as it was
 * `before`. */
static const real *with_inputs(const Model *m, const real *before, const real *y)
{
    if (m->n_u == 0) return y;
    copy(m->row, y, m->n_row);
    for (integer i = 0; i < m->n_u; i++)
        if (!isfinite(y[m->n_y + i])) m->row[m->n_y + i] = before[i];
    return m->row;
}

/* Which rows have all readings they need, and readings with zero where there is none; the inputs
 * stay behind them. */
static void mark_present(const Model *m, const real *y, real *present, real *clean)
{
    copy(clean + m->n_y, y + m->n_y, m->n_u);
    for (integer i = 0; i < m->n_y; i++) clean[i] = isfinite(y[i]) ? y[i] : 0;
    for (integer row = 0; row < m->n_r; row++) {
        present[row] = 1;
        for (integer i = 0; i < m->n_y; i++)
            if (m->row_needs[row * m->n_y + i] && !(fabs(y[i]) < m->saturation[i]))
                present[row] = 0;
    }
}

/* The remarks that any estimator makes on an estimate. */
static integer remarks(const Model *m, const real *mean, const real *P, const real *y,
                       const real *used)
{
    integer status = STATUS_NO_READING, digits = *m->lost != 0 ? STATUS_DIGITS_LOST : 0;
    for (integer row = 0; row < m->n_r; row++)
        if (used[row] != 0 && m->measured_rows[row]) status = 0;
    for (integer i = 0; i < m->n_y; i++) {
        if (isinf(y[i])) status |= STATUS_INFINITE_READING;
        if (isfinite(y[i]) && fabs(y[i]) >= m->saturation[i]) status |= STATUS_SATURATED;
    }
    real margin = 0;
    const real *arguments[] = {mean};
    real *results[] = {&margin};
    call(m, &m->regularity, arguments, results);
    if (fabs(margin) < m->regularity_limit) status |= STATUS_NEAR_SINGULAR;
    for (integer i = 0; m->reach && i < m->n_x; i++)
        if (variance(m, P, i) > m->reach[i] * m->reach[i])
            status |= STATUS_OUT_OF_REACH;
    *m->lost = 0;
    return status | digits;
}

/* Outputs that are not states, with their standard deviations. */
static void derive(const Model *m, const real *mean, const real *covariance, real *derived, real *std)
{
    if (!m->derived.evaluate) return;
    const real *arguments[] = {mean, covariance};
    real *results[] = {derived, std};
    call(m, &m->derived, arguments, results);
}

static void derive_result(const Model *m, const Result *r, real *result)
{
    derive(m, result + r->mean, result + r->covariance, result + r->derived, result + r->derived_std);
}

static void report(const Model *m, const Result *r, real *result, real time,
                   const real *mean, const real *P, const real *v, const real *S,
                   const real *present, integer status)
{
    result[r->time_s] = time;
    copy(result + r->mean, mean, m->n_x);
    covariance_of(m, P, result + r->covariance);
    derive_result(m, r, result);
    for (integer row = 0; row < m->n_r; row++)
        result[r->innovation + row] = present[row] != 0 ? v[row] : NAN;
    copy(result + r->innovation_covariance, S, m->n_r * m->n_r);
    result[r->status] = (real)status;
    result[r->cost] = NAN;
    result[r->kkt] = NAN;
    result[r->reused] = 0;
}

/* The answer to a measurement that is older than the state. */
static void report_late(const Model *m, const Result *r, real *result, real time,
                        const real *mean, const real *P)
{
    result[r->time_s] = time;
    copy(result + r->mean, mean, m->n_x);
    covariance_of(m, P, result + r->covariance);
    derive_result(m, r, result);
    for (integer i = 0; i < m->n_r; i++) result[r->innovation + i] = NAN;
    for (integer i = 0; i < m->n_r * m->n_r; i++) result[r->innovation_covariance + i] = NAN;
    result[r->status] = STATUS_LATE;
    result[r->iterations] = 0;
    result[r->cost] = NAN;
    result[r->kkt] = NAN;
    result[r->reused] = 0;
}

/* A whole recording: the same step, n times. `memory` holds two states; returns which
 * of them is the last. */
static inline int batch(step_function step, void *self, real *memory[2], integer n,
                        const real *time, const real *y, integer n_row, real *results,
                        integer result_size)
{
    int at = 0;
    for (integer k = 0; k < n; k++, at = !at)
        step(self, memory[at], memory[!at], time[k], y + k * n_row, results + k * result_size);
    return at;
}
