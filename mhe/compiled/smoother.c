/* The pass back: modified Bryson-Frazier, with multipliers of constraint rows as impulses on the
 * costates. Behind mhe/compiled/factors.c.
 *
 * A multiplier ν of a row g + C' δ ≤ 0 at stage k adds ν C' δ to the cost: a pseudo-measurement
 * without noise, whose value is chosen. The filter's mean behind it shifts by -P⁺ C ν,
 * its covariance does not, so all factors of the forward pass stay. */

#define FREE 0
#define PUSHED 1
#define HELD 2

/* Let a shift of the mean behind stage k - 1 go on through stage k: what it changes in e
 * and in δ⁺. */
static void propagate(const Window *s, integer k, const real *shift, real *e_shift, real *d_shift)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const real *arguments[] = {shift, SLOT(o->F, k - 1, s->nnz_F),
                               SLOT(o->W, k, m->n_x * m->n_r), SLOT(o->L, k, s->nnz_L),
                               SLOT(o->H, k, s->nnz_H)};
    real *results[] = {e_shift, d_shift};
    s->propagate(arguments, results, 0, 0, 0);
}

/* λ̂ of stage k, and w_s of its noise where it is wanted, from λ of the stage behind it. */
static void retreat(const Window *s, integer k, const real *lambda, const real *noise_scale,
                    real *lambda_hat, real *w_s)
{
    const real *arguments[] = {lambda, SLOT(s->work.F, k, s->nnz_F), SLOT(s->work.G, k, s->nnz_G),
                               STAGE(noise_scale, k, s->model.n_w)};
    real *results[] = {lambda_hat, w_s};
    s->retreat(arguments, results, 0, 0, 0);
}

/* Shift the filter's means by the impulses, from stage `first` on. */
static void push(const Window *s, integer count, integer first)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    memset(o->d_shift, 0, (size_t)((first + 1) * n_x) * sizeof(real));
    memset(o->e_shift, 0, (size_t)((first + 1) * n_r) * sizeof(real));
    for (integer k = first; k + 1 < count; k++) {
        spread(m, SLOT(o->P_plus, k, n_x * n_x), STAGE(o->impulse, k, n_x), o->spread);
        for (integer i = 0; i < n_x; i++)
            o->shift[i] = STAGE(o->d_shift, k, n_x)[i] - o->spread[i];
        propagate(s, k + 1, o->shift, STAGE(o->e_shift, k + 1, n_r), STAGE(o->d_shift, k + 1, n_x));
    }
}

#if CONVERGES
/* Back through the rows that a stage was conditioned on: their multipliers, and λ̂ in front. */
static void release_rows(const Window *s, integer k, real *lambda_hat)
{
    const Work *o = &s->work;
    const integer n_x = s->model.n_x, n_c = s->n_c;
    for (integer i = (k + 1) * n_c - 1; i >= k * n_c; i--) {
        if (o->is_held[i] == 0) continue;
        const real *W = STAGE(o->row_PC, i, n_x), *C = STAGE(o->row_C, i, n_x);
        o->row_multiplier[i] = -(dot(W, lambda_hat, n_x) + o->row_e[i]) / o->row_std_held[i];
        for (integer a = 0; a < n_x; a++) lambda_hat[a] += o->row_multiplier[i] * C[a];
    }
}
#endif

/* Squared length of a step of noises. */
static real noise_length(const Window *s, const real *w_s, const real *w, const real *noise_scale,
                         integer count)
{
    real length = 0;
    for (integer i = 0; i < count * s->model.n_w; i++) {
        const real step = (w_s[i] - w[i]) / noise_scale[i];
        length += step * step;
    }
    return length;
}

/* Smoothed deviation d_s of stage k, its expected residuals, and λ in front of it, from λ̂. Returns
 * the squared length of its readings' step. */
static real smooth_stage(const Window *s, integer k, int rows)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    const real *d_plus = SLOT(o->d_plus, k, n_x), *e = SLOT(o->e, k, n_r);
    real length = 0;
    if (rows == PUSHED) {
        for (integer i = 0; i < n_x; i++) {
            o->lambda_hat[i] += STAGE(o->impulse, k, n_x)[i];
            o->d_pushed[i] = d_plus[i] + STAGE(o->d_shift, k, n_x)[i];
        }
        for (integer i = 0; i < n_r; i++) o->e_pushed[i] = e[i] + STAGE(o->e_shift, k, n_r)[i];
        d_plus = o->d_pushed;
        e = o->e_pushed;
    }
    spread(m, SLOT(o->P_plus, k, n_x * n_x), o->lambda_hat, o->spread);
#if CONVERGES
    if (rows == HELD) release_rows(s, k, o->lambda_hat);
#endif
    const real *stage[] = {d_plus, o->spread, o->lambda_hat, SLOT(o->W, k, n_x * n_r), e,
                           SLOT(o->L, k, s->nnz_L), SLOT(o->H, k, s->nnz_H)};
    real *smoothed[] = {STAGE(o->d_s, k, n_x), o->lambda, &length, STAGE(o->expected, k, n_r)};
    s->smooth(stage, smoothed, 0, 0, 0);
    return length;
}

/* Smoothed deviations d_s and, in `g`, the linearised optimum (μ, w_0, w_1, …), with the
 * impulses where it is PUSHED, through the rows that stages were conditioned on where these are
 * HELD. Returns the squared length of the step from w in units of the whitened problem, without
 * the prior's part. */
static real backward(const Window *s, const real *memory, const real *w, const real *noise_scale,
                     int rows, real *g)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count];
    const integer n_x = s->model.n_x, n_w = s->model.n_w;
    real length = 0;
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(real));
    for (integer k = count - 1; k >= 0; k--) {
        if (k < count - 1)
            retreat(s, k, o->lambda, noise_scale, o->lambda_hat, STAGE(g + n_x, k, n_w));
        length += smooth_stage(s, k, rows);
    }
    for (integer i = 0; i < n_x; i++) g[i] = -o->lambda[i];
#if CONVERGES
    if (s->iterate && s->carry) carry_back(s, g);
#endif
    return length + noise_length(s, g + n_x, w, noise_scale, count - 1);
}
