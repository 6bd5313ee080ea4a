/* The pass back: modified Bryson-Frazier, with multipliers of constraint rows as impulses on the
 * costates. Behind mhe/compiled/factors.c.
 *
 * A multiplier ν of a row g + C' δ ≤ 0 at stage k adds ν C' δ to the cost: a pseudo-measurement
 * without noise, whose value is chosen. The filter's mean behind it shifts by -P⁺ C ν,
 * its covariance does not, so all factors of the forward pass stay. */

#define FREE 0
#define PUSHED 1
#define HELD 2

/* Let a shift of the mean behind stage k - 1 go on through stage k: z = F s, then what it changes
 * in e, -L⁻¹ H z, and in δ⁺, z + W Δe. */
static void propagate(const Window *s, integer k, const real *shift, real *e_shift, real *d_shift)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    const real *F = SLOT(o->F, k - 1, s->nnz_F), *H = SLOT(o->H, k, s->nnz_H);
    const real *W = SLOT(o->W, k, s->model.stride * n_r), *L = SLOT(o->L, k, s->nnz_L);
    const real *present = SLOT(o->at_rows, k, n_r);
    for (integer i = 0; i < n_x; i++) {
        d_shift[i] = m->F_unit[i] * shift[i];
        for (integer j = m->F_at[i]; j < m->F_at[i + 1]; j++)
            d_shift[i] += F[j] * shift[m->F_column[j]];
    }
    for (integer r = 0; r < n_r; r++) {
        e_shift[r] = 0;
        if (present[r] == 0) continue;
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++)
            e_shift[r] -= H[j] * d_shift[m->H_column[j]];
        e_shift[r] = (e_shift[r] - dot(ROW(L, r), e_shift, r)) / ROW(L, r)[r];
    }
    for (integer r = 0; r < n_r; r++)
        for (integer i = 0; present[r] != 0 && i < n_x; i++) d_shift[i] += W[r * m->stride + i] * e_shift[r];
}

/* λ̂ = Fᵀ λ of stage k, and w_s = -D² Gᵀ λ of its noise where it is wanted, from λ of the stage
 * behind it. */
static void retreat(const Window *s, integer k, const real *lambda, const real *noise_scale,
                    real *lambda_hat, real *w_s)
{
    const Model *m = &s->model;
    const real *F = SLOT(s->work.F, k, s->nnz_F), *G = SLOT(s->work.G, k, s->nnz_G);
    const real *scale = STAGE(noise_scale, k, m->n_w);
    for (integer i = 0; i < m->n_x; i++) lambda_hat[i] = m->F_unit[i] * lambda[i];
    for (integer i = 0; i < m->n_x; i++)
        for (integer j = m->F_at[i]; j < m->F_at[i + 1]; j++)
            lambda_hat[m->F_column[j]] += F[j] * lambda[i];
    for (integer w = 0; w_s && w < m->n_w; w++) {
        real sum = 0;
        for (integer j = m->G_at[w]; j < m->G_at[w + 1]; j++) sum += G[j] * lambda[m->G_row[j]];
        w_s[w] = -(scale[w] * scale[w] * sum);
    }
}

/* u = L⁻ᵀ (Wᵀ λ̂ + e) of the rows present, and λ = λ̂ - Hᵀ u in front of them. */
static void absorb(const Window *s, integer k, const real *lambda_hat, const real *e, real *u,
                   real *lambda)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    const real *W = SLOT(o->W, k, s->model.stride * n_r), *L = SLOT(o->L, k, s->nnz_L);
    const real *H = SLOT(o->H, k, s->nnz_H), *present = SLOT(o->at_rows, k, n_r);
    copy(lambda, lambda_hat, n_x);
    for (integer r = 0; r < n_r; r++)
        u[r] = present[r] != 0 ? dot(W + r * m->stride, lambda_hat, n_x) + e[r] : 0;
    for (integer r = n_r - 1; r >= 0; r--) {
        if (present[r] == 0) continue;
        u[r] /= ROW(L, r)[r];
        for (integer q = 0; q < r; q++)
            if (present[q] != 0) u[q] -= ROW(L, r)[q] * u[r];
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++)
            lambda[m->H_column[j]] -= H[j] * u[r];
    }
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
        spread(m, SLOT(o->P_plus, k, s->model.n_P), STAGE(o->impulse, k, n_x), o->spread);
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
    spread(m, SLOT(o->P_plus, k, s->model.n_P), o->lambda_hat, o->spread);
#if CONVERGES
    if (rows == HELD) release_rows(s, k, o->lambda_hat);
#endif
    real *d_s = STAGE(o->d_s, k, n_x), *expected = STAGE(o->expected, k, n_r);
    const real *H = SLOT(o->H, k, s->nnz_H);
    absorb(s, k, o->lambda_hat, e, expected, o->lambda);
    for (integer i = 0; i < n_x; i++) d_s[i] = d_plus[i] - o->spread[i];
    for (integer r = 0; r < n_r; r++) {
        real moved = 0;
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++) moved += H[j] * d_s[m->H_column[j]];
        moved /= m->noise_std[r];
        length += moved * moved;
        expected[r] *= m->noise_std[r];
    }
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
    if (s->iterate && s->carry.evaluate) carry_back(s, g);
#endif
    return length + noise_length(s, g + n_x, w, noise_scale, count - 1);
}
