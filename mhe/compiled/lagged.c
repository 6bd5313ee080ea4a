/* What a window says of its earlier stages: estimates at a fixed lag. Behind mhe/compiled/smoother.c;
 * mhe/look_back.py is the same in Python.
 *
 * Column i of the smoothed covariance P_s of a stage is what a unit impulse on its own state i takes
 * from its estimate: the filter's mean shifts by -P⁺ 1_i, that goes on to the newest stage, and what
 * the readings there make of it comes back as a costate,
 *
 *     P_s 1_i = P⁺ (1_i + λ̂).
 *
 * All columns go through the factors at once: rows of a matrix added to each other. */

/* Of which stage a lag speaks, with `count` of them; below 0 where the window is not that long yet. */
static inline integer stage_at_lag(const Window *s, integer count, integer i)
{
    return count - 1 - s->lags[i];
}

/* The oldest stage that a lag speaks of; `count` where there is none. */
static inline integer oldest_told(const Window *s, integer count)
{
    integer oldest = count;
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        if (at >= 0 && at < oldest) oldest = at;
    }
    return oldest;
}

/* y += a x of n numbers. */
static inline void add_to(real *restrict y, real a, const real *restrict x, integer n)
{
    for (integer i = 0; i < n; i++) y[i] += a * x[i];
}

/* `propagate` of all columns of `shift` (n_x, n_x) at once, in place; Δe (n_r, n_x) of stage k. */
static void propagate_all(const Window *s, integer k, real *shift, real *e_shift)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    const real *F = SLOT(o->F, k - 1, s->nnz_F), *H = SLOT(o->H, k, s->nnz_H);
    const real *W = SLOT(o->W, k, s->model.stride * n_r), *L = SLOT(o->L, k, s->nnz_L);
    const real *present = SLOT(o->at_rows, k, n_r);
    real *z = o->all_lagged;
    for (integer i = 0; i < n_x; i++) {
        real *row = STAGE(z, i, n_x);
        for (integer c = 0; c < n_x; c++) row[c] = m->F_unit[i] * STAGE(shift, i, n_x)[c];
        for (integer j = m->F_at[i]; j < m->F_at[i + 1]; j++)
            add_to(row, F[j], STAGE(shift, m->F_column[j], n_x), n_x);
    }
    copy(shift, z, n_x * n_x);
    for (integer r = 0; r < n_r; r++) {
        real *e = STAGE(e_shift, r, n_x);
        if (present[r] == 0) continue;
        memset(e, 0, (size_t)n_x * sizeof(real));
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++)
            add_to(e, -H[j], STAGE(z, m->H_column[j], n_x), n_x);
        for (integer q = 0; q < r; q++)
            if (present[q] != 0) add_to(e, -ROW(L, r)[q], STAGE(e_shift, q, n_x), n_x);
        for (integer c = 0; c < n_x; c++) e[c] /= ROW(L, r)[r];
        for (integer i = 0; i < n_x; i++) add_to(STAGE(shift, i, n_x), W[r * m->stride + i], e, n_x);
    }
}

/* `absorb` and `retreat` of all columns of λ̂ (n_x, n_x) at once, in place: from behind the readings of
 * stage k to behind those of the stage before; Δe is used up. */
static void retreat_all(const Window *s, integer k, real *lambda, real *e_shift)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r;
    const real *F = SLOT(o->F, k - 1, s->nnz_F), *H = SLOT(o->H, k, s->nnz_H);
    const real *W = SLOT(o->W, k, s->model.stride * n_r), *L = SLOT(o->L, k, s->nnz_L);
    const real *present = SLOT(o->at_rows, k, n_r);
    real *before = o->all_lagged;
    for (integer r = 0; r < n_r; r++)
        for (integer i = 0; present[r] != 0 && i < n_x; i++)
            add_to(STAGE(e_shift, r, n_x), W[r * m->stride + i], STAGE(lambda, i, n_x), n_x);
    for (integer r = n_r - 1; r >= 0; r--) {
        real *u = STAGE(e_shift, r, n_x);
        if (present[r] == 0) continue;
        for (integer c = 0; c < n_x; c++) u[c] /= ROW(L, r)[r];
        for (integer q = 0; q < r; q++)
            if (present[q] != 0) add_to(STAGE(e_shift, q, n_x), -ROW(L, r)[q], u, n_x);
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++)
            add_to(STAGE(lambda, m->H_column[j], n_x), -H[j], u, n_x);
    }
    for (integer i = 0; i < n_x; i++)
        for (integer c = 0; c < n_x; c++)
            STAGE(before, i, n_x)[c] = m->F_unit[i] * STAGE(lambda, i, n_x)[c];
    for (integer i = 0; i < n_x; i++)
        for (integer j = m->F_at[i]; j < m->F_at[i + 1]; j++)
            add_to(STAGE(before, m->F_column[j], n_x), F[j], STAGE(lambda, i, n_x), n_x);
    copy(lambda, before, n_x * n_x);
}

/* P_s (n_x, n_x) of stage `at`. What rounding leaves of P⁺ is its least. */
static void smoothed_covariance(const Window *s, integer count, integer at, real *P_s)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_r = m->n_r, n = n_x * n_x;
    const real *P_plus = SLOT(o->P_plus, at, s->model.n_P);
    real *shift = P_s, *lambda = P_s; /* one after the other */
    covariance_of(m, P_plus, shift);
    for (integer i = 0; i < n; i++) shift[i] = -shift[i];
    for (integer k = at + 1; k < count; k++)
        propagate_all(s, k, shift, STAGE(o->e_lagged, k, n_r * n_x));
    memset(lambda, 0, (size_t)n * sizeof(real));
    for (integer k = count - 1; k > at; k--)
        retreat_all(s, k, lambda, STAGE(o->e_lagged, k, n_r * n_x));
    for (integer i = 0; i < n_x; i++) lambda[i * (n_x + 1)] += 1;
    for (integer c = 0; c < n_x; c++) {
        for (integer i = 0; i < n_x; i++) o->shift[i] = lambda[i * n_x + c];
        spread(m, P_plus, o->shift, STAGE(o->all_lagged, c, n_x));
    }
    for (integer i = 0; i < n_x; i++) {
        for (integer j = 0; j <= i; j++)
            P_s[i * n_x + j] = P_s[j * n_x + i]
                = (o->all_lagged[i * n_x + j] + o->all_lagged[j * n_x + i]) / 2;
        const real least = LEAST_SHARE * variance(m, P_plus, i);
        if (P_s[i * (n_x + 1)] < least) P_s[i * (n_x + 1)] = least;
    }
}

/* Look back from a window whose factors are those of its trajectory: states and smoothed covariances at
 * all lags. */
static void look_back(const Window *s, const real *memory)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        if (at < 0) continue;
        copy(STAGE(o->x_lagged, i, n_x), STAGE(memory + s->memory.x, at, n_x), n_x);
        smoothed_covariance(s, count, at, STAGE(o->P_lagged, i, n_x * n_x));
    }
}

/* Where there was no pass: states as they were before, and nothing about how well they are known. */
static void look_back_without_pass(const Window *s, const real *memory)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        if (at >= 0) copy(STAGE(o->x_lagged, i, n_x), STAGE(memory + s->memory.x, at, n_x), n_x);
    }
    for (integer i = 0; i < s->n_lags * n_x * n_x; i++) o->P_lagged[i] = NAN;
}

/* Write what was looked back at; NaN where a lag reaches beyond the window's `count` stages. */
static void tell_lagged(const Window *s, const real *memory, integer count, real *result)
{
    const Result *r = &s->result;
    const Work *o = &s->work;
    const integer n_x = s->model.n_x, n = n_x * n_x;
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        real *mean = STAGE(result + r->lagged_mean, i, n_x);
        real *covariance = STAGE(result + r->lagged_covariance, i, n);
        result[r->lagged_time + i] = at < 0 ? NAN : memory[s->memory.times + at];
        for (integer a = 0; a < n_x; a++) mean[a] = at < 0 ? NAN : STAGE(o->x_lagged, i, n_x)[a];
        for (integer a = 0; a < n; a++) covariance[a] = at < 0 ? NAN : STAGE(o->P_lagged, i, n)[a];
    }
}
