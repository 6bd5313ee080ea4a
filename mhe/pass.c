/* A Gauss-Newton pass over the window: Kalman stages forward, a smoother back. Behind
 * estimation/engine.c; the structures Memory, Work and Window are declared in front.
 *
 * `memory` is the state: stages oldest first, `count` of them. Work arrays hold one entry
 * per stage of what the forward pass leaves for the backward pass. */

#define STAGE(array, k, width) ((array) + (k) * (width))

static void move(const Window *s, const real *x, const real *w, real dt, real *reached)
{
    const real *arguments[] = {x, w, &dt};
    real *results[] = {reached};
    s->move(arguments, results, 0, 0, 0);
}

static void difference(const Window *s, const real *to, const real *from, real *delta)
{
    const real *arguments[] = {to, from};
    real *results[] = {delta};
    s->difference(arguments, results, 0, 0, 0);
}

static real interval(const Window *s, const real *memory, integer k)
{
    const real *times = memory + s->memory.times;
    return times[k + 1] - times[k];
}

/* The multiplier μ of a deviation d = P̄ μ from the prior mean, by a Cholesky factor of P̄.
 * Only the first guess of a window needs it: every later deviation is P̄ times something.
 * Returns d' P̄⁻¹ d; where there is no factor, infinity, and μ is zero. */
static real prior_multiplier(const Window *s, const real *P, const real *d, real *mu)
{
    const integer n = s->model.n_x;
    real *L = s->work.L_prior, sum = 0;
    memset(mu, 0, (size_t)n * sizeof(real));
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++) {
            const real left = P[i * n + j] - dot(L + i * n, L + j * n, j);
            if (i == j && !(left > 0)) return INFINITY;
            L[i * n + j] = i == j ? sqrt(left) : left / L[j * n + j];
        }
    for (integer i = 0; i < n; i++) {
        mu[i] = (d[i] - dot(L + i * n, mu, i)) / L[i * n + i];
        sum += mu[i] * mu[i];
    }
    for (integer i = n - 1; i >= 0; i--) {
        for (integer j = i + 1; j < n; j++) mu[i] -= L[j * n + i] * mu[j];
        mu[i] /= L[i * n + i];
    }
    return sum;
}

/* Inner product of two vectors (μ, w_0, w_1, …) in units of the whitened problem. */
static real inner(const Window *s, const real *memory, const real *a, const real *b)
{
    const integer n = s->model.n_x, noises = ((integer)memory[s->memory.count] - 1) * s->model.n_w;
    const real *P = memory + s->memory.prior_covariance;
    real sum = dot(a + n, b + n, noises);
    for (integer i = 0; i < n; i++) sum += a[i] * dot(P + i * n, b, n);
    return sum;
}

/* Cost of readings and noises of a trajectory, and the scales by which its losses weigh
 * them; the prior's part is the caller's. */
static real measure(const Window *s, const real *memory, const real *x, const real *w,
                      real *row_scale, real *noise_scale)
{
    const Model *m = &s->model;
    const integer count = (integer)memory[s->memory.count];
    const real *y = memory + s->memory.y, *present = memory + s->memory.present;
    real cost = 0, part = 0;
    for (integer k = 0; k < count; k++) {
        const real *seen[] = {STAGE(x, k, m->n_x), STAGE(y, k, m->n_y),
                                STAGE(present, k, m->n_r), s->huber};
        real *scales[] = {STAGE(row_scale, k, m->n_r), &part};
        s->measure(seen, scales, 0, 0, 0);
        cost += part;
    }
    for (integer k = 0; k + 1 < count; k++) {
        const real *shaken[] = {STAGE(w, k, m->n_w), &s->huber_noise};
        real *scales[] = {STAGE(noise_scale, k, m->n_w), &part};
        s->shake(shaken, scales, 0, 0, 0);
        cost += part;
    }
    return cost;
}

/* Kalman stages over the window, linearised at its trajectory, whose first state is x̄ ⊞ d.
 * Returns the sum of squared whitened innovations. */
static real forward(const Window *s, const real *memory, const real *d,
                      const real *row_scale, const real *noise_scale)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const real *x = memory + s->memory.x, *w = memory + s->memory.w;
    const real *y = memory + s->memory.y;
    const real *P_minus = memory + s->memory.prior_covariance;
    real squares = 0;
    for (integer i = 0; i < n_x; i++) o->d_minus[i] = -d[i];
    for (integer k = 0; k < count; k++) {
        if (k > 0) {
            const real dt = interval(s, memory, k - 1);
            real *predicted[] = {o->reached, o->d_minus, o->P_minus,
                                   STAGE(o->F, k - 1, s->nnz_F), STAGE(o->G, k - 1, s->nnz_G)};
            predict(m, STAGE(o->d_plus, k - 1, n_x), STAGE(o->P_plus, k - 1, n_x * n_x),
                    STAGE(x, k - 1, n_x), STAGE(w, k - 1, m->n_w), &dt,
                    STAGE(noise_scale, k - 1, m->n_w), predicted);
            difference(s, o->reached, STAGE(x, k, n_x), o->defect);
            for (integer i = 0; i < n_x; i++) o->d_minus[i] += o->defect[i];
            P_minus = o->P_minus;
        }
        const int newest = k == count - 1;
        real *updated[] = {STAGE(o->d_plus, k, n_x),  STAGE(o->P_plus, k, n_x * n_x),
                             newest ? o->v : 0,         newest ? o->S : 0,
                             STAGE(o->W, k, n_x * n_r), STAGE(o->e, k, n_r),
                             STAGE(o->H, k, s->nnz_H),  STAGE(o->L, k, s->nnz_L)};
        update(m, o->d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_y),
               STAGE(row_scale, k, n_r), updated);
        squares += dot(STAGE(o->e, k, n_r), STAGE(o->e, k, n_r), n_r);
        if (newest && s->has_losses) { /* told is the innovation itself, not its weighed share */
            real *told[] = {0, 0, o->v, o->S, 0, 0, 0, 0};
            update(m, o->d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_y),
                   STAGE(memory + s->memory.present, k, n_r), told);
        }
    }
    return squares;
}

/* Modified Bryson-Frazier pass back: smoothed deviations d_s and, in `g`, the linearised
 * optimum (μ, w_0, w_1, …). Returns the squared length of the step from w in units of the
 * whitened problem, without the prior's part. */
static real backward(const Window *s, const real *memory, const real *noise_scale,
                       real *g)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const integer n_w = m->n_w;
    const real *w = memory + s->memory.w;
    real length = 0, part = 0;
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(real));
    for (integer k = count - 1; k >= 0; k--) {
        if (k < count - 1) {
            real *w_s = STAGE(g + n_x, k, n_w);
            const real *ahead[] = {o->lambda, STAGE(o->F, k, s->nnz_F),
                                     STAGE(o->G, k, s->nnz_G), STAGE(noise_scale, k, n_w)};
            real *back[] = {o->lambda_hat, w_s};
            s->retreat(ahead, back, 0, 0, 0);
            for (integer i = 0; i < n_w; i++) {
                const real step = (w_s[i] - w[k * n_w + i]) / noise_scale[k * n_w + i];
                length += step * step;
            }
        }
        spread(m, STAGE(o->P_plus, k, n_x * n_x), o->lambda_hat, o->spread);
        const real *stage[] = {STAGE(o->d_plus, k, n_x), o->spread,
                                 o->lambda_hat,            STAGE(o->W, k, n_x * n_r),
                                 STAGE(o->e, k, n_r),      STAGE(o->L, k, s->nnz_L),
                                 STAGE(o->H, k, s->nnz_H)};
        real *smoothed[] = {STAGE(o->d_s, k, n_x), o->lambda, &part};
        s->smooth(stage, smoothed, 0, 0, 0);
        length += part;
    }
    for (integer i = 0; i < n_x; i++) g[i] = -o->lambda[i];
    return length;
}

/* One pass: the linearised window's optimum becomes the trajectory. */
static integer one_pass(const Window *s, real *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x;
    real *x = memory + s->memory.x, *w = memory + s->memory.w;
    const real *row_scale = memory + s->memory.present, *noise_scale = o->unit_noises;
    real readings = 0;
    if (s->has_losses) {
        readings = measure(s, memory, x, w, o->row_scale, o->noise_scale);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    difference(s, x, memory + s->memory.prior_mean, o->d);
    const real squares = forward(s, memory, o->d, row_scale, noise_scale);
    const real length = backward(s, memory, noise_scale, o->g);
    if (!isfinite(readings) || !isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
    for (integer k = 0; k < count; k++)
        retract(m, STAGE(x, k, n_x), STAGE(o->d_s, k, n_x), STAGE(x, k, n_x));
    copy(w, o->g + n_x, (count - 1) * m->n_w);
    return 0;
}
