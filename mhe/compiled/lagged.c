/* What a window says of its earlier stages: estimates at a fixed lag. Behind
 * mhe/compiled/smoothed_covariance.c; mhe/look_back.py is the same in Python. */

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

/* Look back from a window whose factors are those of its trajectory: states and smoothed covariances at
 * all lags. */
static void look_back(const Window *s, const real *memory)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x, n = n_x * n_x;
    integer k = count - 1;
    begin_costates(s);
    for (integer i = 0; i < s->n_lags && stage_at_lag(s, count, i) >= 0; i++) {
        for (; k > stage_at_lag(s, count, i); k--) costates_before(s, k);
        copy(STAGE(o->x_lagged, i, n_x), STAGE(memory + s->memory.x, k, n_x), n_x);
        smoothed_covariance(s, k, STAGE(o->P_lagged, i, n));
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
    const integer n_x = s->model.n_x, n = n_x * n_x, n_derived = s->n_derived;
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        real *derived = STAGE(result + r->lagged_derived, i, n_derived);
        real *std = STAGE(result + r->lagged_derived_std, i, n_derived);
        real *mean = STAGE(result + r->lagged_mean, i, n_x);
        real *covariance = STAGE(result + r->lagged_covariance, i, n);
        result[r->lagged_time + i] = at < 0 ? NAN : memory[s->memory.times + at];
        for (integer a = 0; a < n_x; a++) mean[a] = at < 0 ? NAN : STAGE(o->x_lagged, i, n_x)[a];
        for (integer a = 0; a < n; a++) covariance[a] = at < 0 ? NAN : STAGE(o->P_lagged, i, n)[a];
        derive(&s->model, mean, covariance, derived, std);
        for (integer a = 0; a < n_derived; a++) {
            if (at < 0) derived[a] = NAN;
            if (isnan(covariance[0])) std[a] = NAN;
        }
    }
}
