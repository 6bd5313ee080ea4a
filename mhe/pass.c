/* A Gauss-Newton pass over the window: Kalman stages forward, a smoother back. Behind
 * estimation/engine.c; the structures Memory, Work and Window are declared in front.
 *
 * `memory` is the state: stages oldest first, `count` of them. Work arrays hold one entry
 * per stage of what the forward pass leaves for the backward pass. */

#define STAGE(array, k, width) ((array) + (k) * (width))

static void move(const Window *s, const double *x, const double *w, double dt, double *reached)
{
    const double *arguments[] = {x, w, &dt};
    double *results[] = {reached};
    s->move(arguments, results, 0, 0, 0);
}

static void difference(const Window *s, const double *to, const double *from, double *delta)
{
    const double *arguments[] = {to, from};
    double *results[] = {delta};
    s->difference(arguments, results, 0, 0, 0);
}

static double interval(const Window *s, const double *memory, long long k)
{
    const double *times = memory + s->memory.times;
    return times[k + 1] - times[k];
}

/* The multiplier μ of a deviation d = P̄ μ from the prior mean, by a Cholesky factor of P̄.
 * Only the first guess of a window needs it: every later deviation is P̄ times something.
 * Returns d' P̄⁻¹ d; where there is no factor, infinity, and μ is zero. */
static double prior_multiplier(const Window *s, const double *P, const double *d, double *mu)
{
    const long long n = s->model.n_x;
    double *L = s->work.L_prior, sum = 0;
    memset(mu, 0, (size_t)n * sizeof(double));
    for (long long i = 0; i < n; i++)
        for (long long j = 0; j <= i; j++) {
            const double left = P[i * n + j] - dot(L + i * n, L + j * n, j);
            if (i == j && !(left > 0)) return INFINITY;
            L[i * n + j] = i == j ? sqrt(left) : left / L[j * n + j];
        }
    for (long long i = 0; i < n; i++) {
        mu[i] = (d[i] - dot(L + i * n, mu, i)) / L[i * n + i];
        sum += mu[i] * mu[i];
    }
    for (long long i = n - 1; i >= 0; i--) {
        for (long long j = i + 1; j < n; j++) mu[i] -= L[j * n + i] * mu[j];
        mu[i] /= L[i * n + i];
    }
    return sum;
}

/* Inner product of two vectors (μ, w_0, w_1, …) in units of the whitened problem. */
static double inner(const Window *s, const double *memory, const double *a, const double *b)
{
    const long long n = s->model.n_x, noises = ((long long)memory[s->memory.count] - 1) * s->model.n_w;
    const double *P = memory + s->memory.prior_covariance;
    double sum = dot(a + n, b + n, noises);
    for (long long i = 0; i < n; i++) sum += a[i] * dot(P + i * n, b, n);
    return sum;
}

/* Cost of readings and noises of a trajectory, and the scales by which its losses weigh
 * them; the prior's part is the caller's. */
static double measure(const Window *s, const double *memory, const double *x, const double *w,
                      double *row_scale, double *noise_scale)
{
    const Model *m = &s->model;
    const long long count = (long long)memory[s->memory.count];
    const double *y = memory + s->memory.y, *present = memory + s->memory.present;
    double cost = 0, part = 0;
    for (long long k = 0; k < count; k++) {
        const double *seen[] = {STAGE(x, k, m->n_x), STAGE(y, k, m->n_y),
                                STAGE(present, k, m->n_r), s->huber};
        double *scales[] = {STAGE(row_scale, k, m->n_r), &part};
        s->measure(seen, scales, 0, 0, 0);
        cost += part;
    }
    for (long long k = 0; k + 1 < count; k++) {
        const double *shaken[] = {STAGE(w, k, m->n_w), &s->huber_noise};
        double *scales[] = {STAGE(noise_scale, k, m->n_w), &part};
        s->shake(shaken, scales, 0, 0, 0);
        cost += part;
    }
    return cost;
}

/* Kalman stages over the window, linearised at its trajectory, whose first state is x̄ ⊞ d.
 * Returns the sum of squared whitened innovations. */
static double forward(const Window *s, const double *memory, const double *d,
                      const double *row_scale, const double *noise_scale)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const double *x = memory + s->memory.x, *w = memory + s->memory.w;
    const double *y = memory + s->memory.y;
    const double *P_minus = memory + s->memory.prior_covariance;
    double squares = 0;
    for (long long i = 0; i < n_x; i++) o->d_minus[i] = -d[i];
    for (long long k = 0; k < count; k++) {
        if (k > 0) {
            const double dt = interval(s, memory, k - 1);
            double *predicted[] = {o->reached, o->d_minus, o->P_minus,
                                   STAGE(o->F, k - 1, s->nnz_F), STAGE(o->G, k - 1, s->nnz_G)};
            predict(m, STAGE(o->d_plus, k - 1, n_x), STAGE(o->P_plus, k - 1, n_x * n_x),
                    STAGE(x, k - 1, n_x), STAGE(w, k - 1, m->n_w), &dt,
                    STAGE(noise_scale, k - 1, m->n_w), predicted);
            difference(s, o->reached, STAGE(x, k, n_x), o->defect);
            for (long long i = 0; i < n_x; i++) o->d_minus[i] += o->defect[i];
            P_minus = o->P_minus;
        }
        const int newest = k == count - 1;
        double *updated[] = {STAGE(o->d_plus, k, n_x),  STAGE(o->P_plus, k, n_x * n_x),
                             newest ? o->v : 0,         newest ? o->S : 0,
                             STAGE(o->W, k, n_x * n_r), STAGE(o->e, k, n_r),
                             STAGE(o->H, k, s->nnz_H),  STAGE(o->L, k, s->nnz_L)};
        update(m, o->d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_y),
               STAGE(row_scale, k, n_r), updated);
        squares += dot(STAGE(o->e, k, n_r), STAGE(o->e, k, n_r), n_r);
        if (newest && s->has_losses) { /* told is the innovation itself, not its weighed share */
            double *told[] = {0, 0, o->v, o->S, 0, 0, 0, 0};
            update(m, o->d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_y),
                   STAGE(memory + s->memory.present, k, n_r), told);
        }
    }
    return squares;
}

/* Modified Bryson-Frazier pass back: smoothed deviations d_s and, in `g`, the linearised
 * optimum (μ, w_0, w_1, …). Returns the squared length of the step from w in units of the
 * whitened problem, without the prior's part. */
static double backward(const Window *s, const double *memory, const double *noise_scale,
                       double *g)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const long long n_w = m->n_w;
    const double *w = memory + s->memory.w;
    double length = 0, part = 0;
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(double));
    for (long long k = count - 1; k >= 0; k--) {
        if (k < count - 1) {
            double *w_s = STAGE(g + n_x, k, n_w);
            const double *ahead[] = {o->lambda, STAGE(o->F, k, s->nnz_F),
                                     STAGE(o->G, k, s->nnz_G), STAGE(noise_scale, k, n_w)};
            double *back[] = {o->lambda_hat, w_s};
            s->retreat(ahead, back, 0, 0, 0);
            for (long long i = 0; i < n_w; i++) {
                const double step = (w_s[i] - w[k * n_w + i]) / noise_scale[k * n_w + i];
                length += step * step;
            }
        }
        const double *stage[] = {STAGE(o->d_plus, k, n_x), STAGE(o->P_plus, k, n_x * n_x),
                                 o->lambda_hat,            STAGE(o->W, k, n_x * n_r),
                                 STAGE(o->e, k, n_r),      STAGE(o->L, k, s->nnz_L),
                                 STAGE(o->H, k, s->nnz_H)};
        double *smoothed[] = {STAGE(o->d_s, k, n_x), o->lambda, &part};
        s->smooth(stage, smoothed, 0, 0, 0);
        length += part;
    }
    for (long long i = 0; i < n_x; i++) g[i] = -o->lambda[i];
    return length;
}

/* One pass: the linearised window's optimum becomes the trajectory. */
static long long one_pass(const Window *s, double *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x;
    double *x = memory + s->memory.x, *w = memory + s->memory.w;
    const double *row_scale = memory + s->memory.present, *noise_scale = o->unit_noises;
    double readings = 0;
    if (s->has_losses) {
        readings = measure(s, memory, x, w, o->row_scale, o->noise_scale);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    difference(s, x, memory + s->memory.prior_mean, o->d);
    const double squares = forward(s, memory, o->d, row_scale, noise_scale);
    const double length = backward(s, memory, noise_scale, o->g);
    if (!isfinite(readings) || !isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
    for (long long k = 0; k < count; k++)
        retract(m, STAGE(x, k, n_x), STAGE(o->d_s, k, n_x), STAGE(x, k, n_x));
    copy(w, o->g + n_x, (count - 1) * m->n_w);
    return 0;
}
