/* Real-time iteration: one pass, and its full step. Behind mhe/compiled/active_set.c.
 *
 * The pass back ends where there is no news. A stage that keeps its factors has been smoothed with
 * them before, and `costate` in the state is the λ̂ that did it: later readings move it by
 * -P⁺ (λ̂ - λ̂ before). Measured in variances P⁺ that only shrinks further back, so where a stage
 * moves by next to nothing it and all before it stay as they are. `away` is how far it then would
 * have moved; an older stage has the sum of it over the stages from itself on at most. */

/* The largest squared deviation of a stage from its linearisation point, in variances that its
 * readings up to then leave. */
static real moved_by(const Window *s, integer k, const real *d_s)
{
    const integer n_x = s->model.n_x;
    const real *P = SLOT(s->work.P_plus, k, s->model.n_P);
    real most = 0;
    for (integer i = 0; i < n_x; i++) {
        const real own = variance(&s->model, P, i), square = d_s[i] * d_s[i];
        if (square > most * own) most = square / own;
    }
    return most;
}

/* The square of what a stage's readings at its estimate are off by, in standard deviations of their
 * noise, from what its linearisation has them. */
static real misjudged(const Window *s, const real *memory, integer k, const real *row_scale)
{
    const Memory *at = &s->memory;
    const integer n_x = s->model.n_x, n_r = s->model.n_r;
    real off = 0;
    const real *judged[] = {STAGE(memory + at->x, k, n_x), STAGE(memory + at->y, k, s->model.n_row),
                            STAGE(row_scale, k, n_r), STAGE(s->work.expected, k, n_r)};
    real *results[] = {&off};
    call(&s->model, &s->judge, judged, results);
    return off * off;
}

/* How far a stage is from its linearisation point, squared: the larger of both measures, the first
 * alone where it says already that the stage has moved. */
static real judged(const Window *s, const real *memory, integer k, const real *d_s,
                   const real *row_scale)
{
    if (!(s->reuse > 0)) return INFINITY;
    const real by = moved_by(s, k, d_s);
    return by > s->reuse * s->reuse ? by : fmax(by, misjudged(s, memory, k, row_scale));
}

/* How far λ̂, instead of the one before, moves stage k, in standard deviations. */
static real news(const Window *s, integer k, const real *before)
{
    const Work *o = &s->work;
    const integer n_x = s->model.n_x;
    for (integer i = 0; i < n_x; i++) o->shift[i] = o->lambda_hat[i] - before[i];
    spread(&s->model, SLOT(o->P_plus, k, s->model.n_P), o->shift, o->spread);
    return sqrt(fmax(dot(o->shift, o->spread, n_x), 0));
}

/* The pass back, to the first stage without news. Returns the oldest stage that it smoothed; noises are
 * written into `w_s`, costates and squared lengths of the steps into the state: a stage's is that of
 * its readings and of the noise that leaves it. */
static integer renew(const Window *s, real *memory, const real *w, const real *noise_scale,
                     real *w_s)
{
    const Work *o = &s->work;
    const Memory *at = &s->memory;
    const integer count = (integer)memory[at->count];
    const integer stayed = s->n_c == 0 ? (integer)memory[at->stayed] : 0;
    const integer n_x = s->model.n_x, n_w = s->model.n_w;
    real *costate = memory + at->costate, *length = memory + at->length, *away = memory + at->away;
    real older = 0;
    for (integer k = 0; k < stayed; k++) older += away[k];
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(real));
    for (integer k = count - 1; k >= 0; k--) {
        if (k < count - 1) retreat(s, k, o->lambda, noise_scale, o->lambda_hat, STAGE(w_s, k, n_w));
        if (k < stayed) {
            const real moves = news(s, k, STAGE(costate, k, n_x));
            older -= away[k];
            if (moves + older <= SETTLED * s->reuse) {
                away[k] = moves;
                return k + 1;
            }
        }
        away[k] = 0;
        copy(STAGE(costate, k, n_x), o->lambda_hat, n_x);
        length[k] = smooth_stage(s, k, FREE);
        if (k < count - 1)
            length[k] += noise_length(s, STAGE(w_s, k, n_w), STAGE(w, k, n_w),
                                      STAGE(noise_scale, k, n_w), 1);
    }
    return 0;
}

#if LAGGED
/* Smooth those older stages that a lag speaks of, behind a pass back that ended at stage `from`; the state
 * and with it all later passes stay as they are. */
static void smooth_told(const Window *s, const real *memory, const real *noise_scale, integer from)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], oldest = oldest_told(s, count);
    for (integer k = from - 1; k >= oldest; k--) {
        if (k < from - 1) retreat(s, k, o->lambda, noise_scale, o->lambda_hat, 0);
        smooth_stage(s, k, FREE);
    }
}

/* Look back behind a pass back that ended at stage `from`. */
static void look_back_from(const Window *s, const real *memory, integer from)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    look_back(s, memory);
    for (integer i = 0; i < s->n_lags; i++) {
        const integer at = stage_at_lag(s, count, i);
        if (at >= 0 && at < from)
            retract(&s->model, STAGE(memory + s->memory.x_lin, at, n_x), STAGE(o->d_s, at, n_x),
                    STAGE(o->x_lagged, i, n_x));
    }
}
#endif

/* Cost of the linearised window's optimum: the whitened innovations' own, and what meeting the rows
 * of the active set adds. */
static real linearised_cost(const Window *s, integer count, integer held)
{
    const Work *o = &s->work;
    const integer n_r = s->model.n_r;
    real cost = 0;
    for (integer k = 0; k < count; k++) cost += dot(SLOT(o->e, k, n_r), SLOT(o->e, k, n_r), n_r) / 2;
    for (integer a = 0; a < held; a++) cost += o->multiplier[a] * o->row_free[o->set[a]] / 2;
    return cost;
}

/* The scales by which losses weigh readings and noises where they are linearised; stages whose factors
 * are of the same point and readings keep theirs. Returns NAN where one is no number. */
static real weigh(const Window *s, const real *memory, const real *x, const real *w)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const Memory *at = &s->memory;
    const integer count = (integer)memory[at->count], n_x = m->n_x, n_r = m->n_r, n_row = m->n_row;
    real cost = 0, part = 0;
    for (integer k = 0; k < count; k++) {
        const real *y = STAGE(memory + at->y, k, n_row);
        real *rows = STAGE(o->row_scale, k, n_r);
        if (k < o->ring[MADE] && same(SLOT(o->at_x, k, n_x), STAGE(x, k, n_x), n_x)
            && same(SLOT(o->at_y, k, n_row), y, n_row)
            && *SLOT(o->at_time, k, 1) == memory[at->times + k]) {
            copy(rows, SLOT(o->at_rows, k, n_r), n_r);
            continue;
        }
        const real *seen[] = {STAGE(x, k, n_x), y, STAGE(memory + at->present, k, n_r), s->huber};
        real *scales[] = {rows, &part};
        call(m, &s->measure, seen, scales);
        cost += part;
    }
    for (integer k = 0; s->huber_noise < LEAST_SQUARES && k + 1 < count; k++) {
        const real *shaken[] = {STAGE(w, k, m->n_w), &s->huber_noise};
        real *scales[] = {STAGE(o->noise_scale, k, m->n_w), &part};
        call(m, &s->shake, shaken, scales);
        cost += part;
    }
    return cost;
}

/* The linearised window's optimum becomes the trajectory. Stages whose estimate is near their
 * linearisation point keep it; see `slide`. */
static integer one_pass(const Window *s, real *memory, Solved *solved)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const Memory *at = &s->memory;
    const integer count = (integer)memory[at->count], n_x = m->n_x, n_w = m->n_w;
    real *x = memory + at->x, *w = memory + at->w, *moved = memory + at->moved, *w_s = o->g + n_x;
    const real *x_lin = memory + at->x_lin, *w_lin = memory + at->w_lin;
    const real *row_scale = memory + at->present, *noise_scale = o->unit_noises;
    real readings = 0, length = 0;
    integer status = 0, held = 0;
    int changed = 0;
    const double began = now(s);
    if (LOSSES && s->has_losses) {
        readings = weigh(s, memory, x_lin, w_lin);
        row_scale = o->row_scale;
        if (s->huber_noise < LEAST_SQUARES) noise_scale = o->noise_scale;
    }
    const real *deviation = memory + at->prior_deviation;
    const real squares = forward(s, memory, deviation, x_lin, w_lin, row_scale, noise_scale, 0);
    const integer from = renew(s, memory, w_lin, noise_scale, w_s);
#if LAGGED
    smooth_told(s, memory, noise_scale, from);
#endif
    const integer before = from > 0 ? from - 1 : 0; /* the noise that leads to `from` is new too */
    copy(w_s, w, before * n_w);
    for (integer k = 0; k < count; k++) length += memory[at->length + k];
    solved->passes = 1;
    if (!isfinite(readings) || !isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
    if (CONSTRAINED && s->n_c > 0) {
        constrain(s, memory, x_lin);
        status = meet_constraints(s, memory, w_lin, noise_scale, &length, o->g, &held, &changed);
    }
    for (integer k = from; k < count; k++) {
        const real *d_s = STAGE(o->d_s, k, n_x);
        retract(m, STAGE(x_lin, k, n_x), d_s, STAGE(x, k, n_x));
        moved[k] = judged(s, memory, k, d_s, row_scale);
    }
    copy(w, w_s, (count - 1) * n_w);
    solved->cost = linearised_cost(s, count, held);
#if LAGGED
    look_back_from(s, memory, from);
#endif
    note_pass(s, count - (integer)memory[at->stayed], began);
    solved->kkt = sqrt(length);
    if (CONSTRAINED && s->n_c > 0)
        solved->kkt = fmax(solved->kkt, exceed(s, memory, x, o->violation, o->row_std));
    return status;
}
