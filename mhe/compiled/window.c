/* The moving horizon: slide the window onto a measurement and solve it. Behind
 * mhe/compiled/one_pass.c and, where windows are converged on, mhe/compiled/second_start.c. */

/* How many of the oldest stages of the window to come keep their linearisation points, and with
 * them their factors: the estimates of all up to there have moved by at most `limit`, a squared
 * distance. None where the stage that is dropped has moved: then the prior is another one. */
static integer staying(const Window *s, const real *given, real limit)
{
    const real *moved = given + s->memory.moved;
    const integer before = (integer)given[s->memory.count], drop = before == s->n_stages;
    integer k = 0;
    if (!(s->reuse > 0)) return 0;
    while (k < before && isfinite(moved[k]) && moved[k] <= limit) k++;
    return k > drop ? k - drop : 0;
}

/* Prior of the first stage that stays, given all readings before it: the dropped stage is
 * eliminated by one update and one prediction; see mhe/arrival_cost.py. As its factors were made,
 * where `kept`: so those behind it stay as they are. `given` is the full window; the new prior is
 * written into `memory`. */
static void arrive(const Window *s, const real *given, int kept, real *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x;
    const real *mean = given + s->memory.prior_mean, *P = given + s->memory.prior_covariance;
    const real *x = given + s->memory.x, *w = given + s->memory.w;
    const real *y = given + s->memory.y, *row_scale = given + s->memory.present;
    const real *noise_scale = o->unit_noises;
    real *new_mean = memory + s->memory.prior_mean;
    real *new_P = memory + s->memory.prior_covariance;
    if (s->arrival == ARRIVAL_none) {
        copy(new_mean, mean, n_x);
        copy(new_P, P, m->n_P);
        return;
    }
    if (s->arrival == ARRIVAL_constant) {
        copy(new_mean, STAGE(given + s->memory.predicted, 1, n_x), n_x);
        copy(new_P, s->constant_covariance, m->n_P);
        return;
    }
    if (LOSSES && s->has_losses) { /* where kept: the weights that its factors are made of */
        real part;
        const real *seen[] = {kept ? given + s->memory.x_lin : x, y, row_scale, s->huber};
        real *weighed[] = {o->row_scale, &part};
        call(&s->model, &s->measure, seen, weighed);
        const real *shaken[] = {w, &s->huber_noise};
        real *shaking[] = {o->noise_scale, &part};
        call(&s->model, &s->shake, shaken, shaking);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    int at_window = s->arrival == ARRIVAL_smoothed;
    const real dt = interval(s, given, 0);
    const real *x_lin = at_window ? x : o->x_prior;
    copy(o->x_prior, mean, n_x);
    keep_inside(s, o->x_prior);
    if (kept) {
        at_window = 1;
        x_lin = given + s->memory.x_lin;
        w = given + s->memory.w_lin;
        copy(o->d_minus_prior, given + s->memory.prior_deviation, n_x);
    } else
        difference(s, mean, x_lin, o->d_minus_prior);
    const int made = kept && has_oldest(s, given, row_scale);
    const real *d_plus = made ? SLOT(o->d_plus, 0, n_x) : o->d_prior;
    const real *P_plus = made ? SLOT(o->P_plus, 0, s->model.n_P) : o->P_prior;
    real *updated[] = {o->d_prior, o->P_prior, 0, 0, 0, 0, 0, 0};
    real *predicted[] = {o->reached, o->d_minus_prior, new_P, 0, 0};
    if (!made) update(m, o->d_minus_prior, P, x_lin, y, row_scale, updated);
    if (!at_window) { /* an EKF: predict from its new mean */
        retract(m, x_lin, o->d_prior, o->reached);
        copy(o->x_prior, o->reached, n_x);
        keep_inside(s, o->x_prior);
        difference(s, o->reached, o->x_prior, o->d_prior);
        w = o->no_noise;
    }
    const real *u[] = {inputs_at(s, given, 0), inputs_at(s, given, 1)};
    predict(m, d_plus, P_plus, x_lin, w, &dt, noise_scale, u, predicted);
    retract(m, o->reached, o->d_minus_prior, new_mean);
    real *deviation = memory + s->memory.prior_deviation;
    const real *first = given + s->memory.x_lin + n_x;
    if (kept) { /* exactly as the forward pass has it: its factors stay */
        difference(s, o->reached, first, o->defect);
        for (integer i = 0; i < n_x; i++) deviation[i] = o->d_minus_prior[i] + o->defect[i];
        if (made) leave(s, given, new_P);
    } else
        difference(s, new_mean, first, deviation);
}

/* Linearisation points of the next pass: the first `k` stages keep theirs; from there on all take
 * their present estimates, for one moved stage changes the factors of all behind it. */
static void choose_points(const Window *s, integer k, real *memory)
{
    const Memory *at = &s->memory;
    const integer count = (integer)memory[at->count], n_x = s->model.n_x, n_w = s->model.n_w;
    real *x_lin = memory + at->x_lin, *deviation = memory + at->prior_deviation;
    copy(STAGE(x_lin, k, n_x), STAGE(memory + at->x, k, n_x), (count - k) * n_x);
    for (integer i = k; i < count; i++) memory[at->moved + i] = INFINITY; /* until a pass says */
    const integer step = k > 0 ? k - 1 : 0; /* the noise that leads to stage k goes with it */
    copy(STAGE(memory + at->w_lin, step, n_w), STAGE(memory + at->w, step, n_w),
         (count - 1 - step) * n_w);
    if (k > 0) return;
    difference(s, x_lin, memory + at->prior_mean, deviation);
    for (integer i = 0; i < n_x; i++) deviation[i] = -deviation[i];
}

/* The readings of stage k, and which of its rows they demand. */
static void take_readings(const Window *s, real *memory, integer k, const real *y)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_y = m->n_y, n_c = s->n_c;
    mark_present(m, y, STAGE(memory + at->present, k, m->n_r), STAGE(memory + at->y, k, m->n_row));
    for (integer j = 0; j < n_c; j++) {
        real *demanded = STAGE(memory + at->demanded, k, n_c) + j;
        *demanded = 1;
        for (integer i = 0; i < n_y; i++)
            if (s->row_conditions[j * n_y + i] && !isfinite(y[i])) *demanded = 0;
        STAGE(memory + at->active, k, n_c)[j] = 0;
    }
}

/* Copy `given` to `memory`, without its oldest stage where the window is full, and append
 * an instant whose state is predicted. The first `stays` stages keep their factors. */
static void slide(const Window *s, const real *given, real *memory, real time, const real *y,
                  integer stays)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_x = m->n_x, n_w = m->n_w, n_row = m->n_row, n_r = m->n_r, n_c = s->n_c;
    const integer before = (integer)given[at->count], drop = before == s->n_stages;
    const integer kept = before - drop;
    const struct { integer at, width, less; } blocks[] = {
        {at->times, 1, 0},   {at->y, n_row, 0},     {at->present, n_r, 0}, {at->x, n_x, 0},
        {at->x_lin, n_x, 0}, {at->moved, 1, 0},     {at->costate, n_x, 0}, {at->away, 1, 0},
        {at->length, 1, 0},  {at->w, n_w, 1},       {at->w_lin, n_w, 1},   {at->active, n_c, 0},
        {at->demanded, n_c, 0}, {at->predicted, n_x, 0}};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++)
        if (kept > blocks[b].less)
            copy(memory + blocks[b].at, given + blocks[b].at + drop * blocks[b].width,
                 (kept - blocks[b].less) * blocks[b].width);
    copy(memory + at->prior_mean, given + at->prior_mean, n_x);
    copy(memory + at->prior_covariance, given + at->prior_covariance, m->n_P);
    copy(memory + at->prior_deviation, given + at->prior_deviation, n_x);
    memory[at->wait] = given[at->wait];
    if (drop) arrive(s, given, stays > 0, memory);
    memory[at->count] = (real)(kept + 1);
    memory[at->times + kept] = time;
    take_readings(s, memory, kept, y);
    copy(memory + at->inputs, y + m->n_y, m->n_u);
    real *newest = STAGE(memory + at->x, kept, n_x);
    if (before == 0)
        copy(newest, memory + at->prior_mean, n_x);
    else {
        real *noise = STAGE(memory + at->w, before - 1 - drop, n_w);
        memset(noise, 0, (size_t)n_w * sizeof(real));
        move(s, memory, kept - 1, STAGE(given + at->x, before - 1, n_x), noise, newest);
    }
    keep_inside(s, newest);
    copy(STAGE(memory + at->predicted, kept, n_x), newest, n_x);
    choose_points(s, stays, memory);
    memory[at->stayed] = (real)stays;
}

/* The last rung: the newest state as predicted from the last estimate, in no time. */
static integer only_predict(const Window *s, const real *given, const real *memory, real *mean,
                            real *covariance)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer before = (integer)given[at->count], newest = (integer)memory[at->count] - 1;
    const integer n_x = m->n_x;
    copy(mean, STAGE(memory + at->x, newest, n_x), n_x);
    copy(covariance, given + at->newest_covariance, m->n_P);
    if (before > 0) {
        const real dt = memory[at->times + newest] - given[at->times + before - 1];
        const real *last = STAGE(given + at->x, before - 1, n_x);
        const real *u[] = {inputs_at(s, memory, newest - 1), inputs_at(s, memory, newest)};
        real *predicted[] = {o->reached, o->d_minus_prior, covariance, 0, 0};
        memset(o->d_prior, 0, (size_t)n_x * sizeof(real));
        predict(m, o->d_prior, given + at->newest_covariance, last, o->no_noise, &dt,
                o->unit_noises, u, predicted);
    }
    for (integer i = 0; i < m->n_r * m->n_r; i++) o->S[i] = NAN;
    note_none(s);
    return STATUS_PREDICTED;
}

/* Slide and solve. Where there is no time to make the factors of all stages that have moved, older
 * ones keep theirs; where there is none for those that have no factors there is no pass. */
static integer attempt(const Window *s, const real *given, real *memory, real time,
                       const real *y, double start, real *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer n_x = m->n_x, before = (integer)given[at->count];
    const integer count = before == s->n_stages ? before : before + 1, newest = count - 1;
    const integer most = affordable(s, start), near = staying(s, given, s->reuse * s->reuse);
    const integer stays = near > count - most ? near : count - most;
    const int has_time = stays <= staying(s, given, INFINITY);
    slide(s, given, memory, time, y, stays);
    Solved solved = {NAN, 0, NAN};
    real *mean = memory + at->newest_mean, *covariance = memory + at->newest_covariance;
    const real *present = STAGE(memory + at->present, newest, m->n_r), *told = present;
    integer status;
    o->reused[0] = 0;
    if (!has_time) {
        status = only_predict(s, given, memory, mean, covariance);
#if LAGGED
        look_back_without_pass(s, memory);
#endif
        told = o->nothing_present;
    } else {
#if CONVERGES
        status = s->iterate ? converge_twice(s, memory, start, &solved) : one_pass(s, memory, &solved);
#else
        status = one_pass(s, memory, &solved);
#endif
        if (stays > near) status |= STATUS_TIME_LIMIT;
        const int is_whole = s->iterate || count == s->n_stages;
        if (status == 0 && is_whole && is_improbable(s, memory, solved.cost))
            status = STATUS_IMPROBABLE;
        copy(mean, STAGE(memory + at->x, newest, n_x), n_x);
        copy(covariance, SLOT(o->P_plus, newest, m->n_P), m->n_P);
    }
    if (!(all_finite(mean, n_x) && is_covariance(m, covariance)))
        status |= STATUS_NOT_FINITE;
    status |= remarks(m, mean, covariance, y, present);
    report(m, &s->result, result, time, mean, covariance, o->v, o->S, told, status);
    result[s->result.iterations] = solved.passes;
    result[s->result.cost] = solved.cost;
    result[s->result.kkt] = solved.kkt;
    result[s->result.reused] = o->reused[0];
#if LAGGED
    tell_lagged(s, memory, count, result);
#endif
    return status;
}

/* A row without readings, with the inputs of y. */
static const real *without_readings(const Window *s, const real *y)
{
    const Model *m = &s->model;
    real *row = s->work.row;
    for (integer i = 0; i < m->n_y; i++) row[i] = NAN;
    copy(row + m->n_y, y + m->n_y, m->n_u);
    return row;
}

/* Where not even the prediction is finite: the window begins anew, with the last estimate. */
static void begin_anew(const Window *s, const real *given, real *memory, real time, const real *y,
                       real *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const real *mean = given + at->newest_mean, *P = given + at->newest_covariance;
    const integer n_x = m->n_x, n_r = m->n_r, means[] = {at->prior_mean, at->newest_mean, at->x,
                                                         at->x_lin, at->predicted};
    for (size_t i = 0; i < sizeof means / sizeof *means; i++) copy(memory + means[i], mean, n_x);
    copy(memory + at->prior_covariance, P, m->n_P);
    copy(memory + at->newest_covariance, P, m->n_P);
    memset(memory + at->prior_deviation, 0, (size_t)n_x * sizeof(real));
    memory[at->count] = 1;
    memory[at->stayed] = memory[at->wait] = 0;
    memory[at->times] = time;
    memory[at->moved] = INFINITY;
    take_readings(s, memory, 0, without_readings(s, y));
    o->ring[MADE] = 0;
    for (integer i = 0; i < n_r * n_r; i++) o->S[i] = NAN;
    report(m, &s->result, result, time, mean, P, o->v, o->S, o->nothing_present,
           STATUS_NOT_FINITE | STATUS_NO_READING);
    result[s->result.iterations] = 0;
#if LAGGED
    tell_lagged(s, memory, 1, result);
#endif
}

void window_step(void *self, const real *given, real *memory, real time, const real *y,
                 real *result)
{
    const Window *s = self;
    const Memory *at = &s->memory;
    const double start = now(s);
    const integer before = (integer)given[at->count];
    if (before > 0 && time < given[at->times + before - 1]) {
        copy(memory, given, at->size);
        report_late(&s->model, &s->result, result, given[at->times + before - 1],
                    given + at->newest_mean, given + at->newest_covariance);
#if LAGGED
        tell_lagged(s, given, 0, result);
#endif
        result[s->result.step_time_s] = (real)(now(s) - start);
        return;
    }
    y = with_inputs(&s->model, given + at->inputs, y);
#if RESTS
    const real dt = before > 0 ? time - given[at->times + before - 1] : 0;
    y = with_rest(&s->model, &s->rest, at, given, memory, dt, y);
#endif
    if (attempt(s, given, memory, time, y, start, result) & STATUS_NOT_FINITE) {
        /* A reading so far off that its square overflows would spoil the window for N
         * steps: the instant stays, its readings go. */
        integer status = attempt(s, given, memory, time, without_readings(s, y), start, result);
        if (status & STATUS_NOT_FINITE)
            begin_anew(s, given, memory, time, y, result);
        else
            result[s->result.status] = (real)((status & ~STATUS_NO_READING) | STATUS_NOT_FINITE);
    }
    result[s->result.step_time_s] = (real)(now(s) - start);
}

int window_batch(Window *s, real *memory, real *other, integer n, const real *time,
                 const real *y, real *results)
{
    real *both[] = {memory, other};
    return batch(window_step, s, both, n, time, y, s->model.n_row, results, s->result.size);
}
