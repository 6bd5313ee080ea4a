/* What a window says of its earlier stages: estimates at a fixed lag. Behind mhe/compiled/smoother.c;
 * mhe/look_back.py is the same in Python.
 *
 * Column i of the smoothed covariance P_s of a stage is what a unit impulse on its own state i takes
 * from its estimate: the filter's mean shifts by -P⁺ 1_i, that goes on to the newest stage, and what
 * the readings there make of it comes back as a costate,
 *
 *     P_s 1_i = P⁺ (1_i + λ̂).
 *
 * Only vectors go through the factors. */

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

/* λ̂ that comes back to stage `at` from a shift of its mean by o->shift. */
static void echo(const Window *s, integer count, integer at)
{
    const Work *o = &s->work;
    const integer n_x = s->model.n_x, n_r = s->model.n_r;
    for (integer k = at + 1; k < count; k++) {
        propagate(s, k, o->shift, STAGE(o->e_lagged, k, n_r), o->spread);
        copy(o->shift, o->spread, n_x);
    }
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(real));
    for (integer k = count - 1; k > at; k--) {
        absorb(s, k, o->lambda_hat, STAGE(o->e_lagged, k, n_r), o->u_lagged, o->lambda);
        retreat(s, k - 1, o->lambda, o->unit_noises, o->lambda_hat, 0);
    }
}

/* P_s (n_x, n_x) of stage `at`. What rounding leaves of P⁺ is its least. */
static void smoothed_covariance(const Window *s, integer count, integer at, real *P_s)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x;
    const real *P_plus = SLOT(o->P_plus, at, s->model.n_P);
    for (integer i = 0; i < n_x; i++) {
        real *column = P_s + i * n_x;
        memset(column, 0, (size_t)n_x * sizeof(real));
        column[i] = 1;
        spread(m, P_plus, column, o->spread);
        for (integer a = 0; a < n_x; a++) o->shift[a] = -o->spread[a];
        echo(s, count, at);
        for (integer a = 0; a < n_x; a++) o->lambda_hat[a] += column[a];
        spread(m, P_plus, o->lambda_hat, o->spread);
        copy(column, o->spread, n_x);
    }
    for (integer i = 0; i < n_x; i++) {
        for (integer j = 0; j < i; j++)
            P_s[i * n_x + j] = P_s[j * n_x + i] = (P_s[i * n_x + j] + P_s[j * n_x + i]) / 2;
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
