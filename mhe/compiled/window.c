/* The moving horizon: a step puts its measurement into the window and solves it. Behind
 * mhe/compiled/slide.c and, where windows are converged on, mhe/compiled/second_start.c. */

/* The last rung: the newest state as predicted from the last estimate, in no time. Where the
 * measurement is late it is the last estimate. */
static integer only_predict(const Window *s, const real *given, const real *memory,
                            const Place *place, real *mean, real *covariance)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer before = (integer)given[at->count], newest = (integer)memory[at->count] - 1;
    const integer n_x = m->n_x;
    copy(mean, STAGE(memory + at->x, newest, n_x), n_x);
    copy(covariance, given + at->newest_covariance, m->n_P);
    if (before > 0 && !place->is_late) {
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

/* Which rows a step has readings of its own for: its stage's, but for those that a late one joined. */
static const real *own_rows(const Window *s, const real *memory, const Place *place, const real *y)
{
    if (!place->joins) return STAGE(memory + s->memory.present, place->at, s->model.n_r);
    mark_present(&s->model, y, s->work.late_rows, s->work.joined);
    return s->work.late_rows;
}

/* S of some of its rows: the others have their noise alone, as where they are missing. */
static void tell_of(const Window *s, const real *rows)
{
    const integer n = s->model.n_r;
    const real *std = s->model.noise_std;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j < n; j++)
            if (rows[i] == 0 || rows[j] == 0) s->work.S[i * n + j] = i == j ? std[i] * std[i] : 0;
}

/* Whether rows bring a sensor's first readings; it counts as seen from then on. */
static int is_first(const Window *s, real *memory, const real *rows)
{
    const Model *m = &s->model;
    real *seen = memory + s->memory.seen;
    int first = 0;
    for (integer sensor = 0; sensor < m->n_sensors; sensor++)
        for (integer row = m->first_row[sensor]; row < m->first_row[sensor + 1]; row++)
            if (rows[row] != 0 && m->measured_rows[row] && seen[sensor] == 0) seen[sensor] = first = 1;
    return first;
}

/* Passes until the step is short: each is linearised where the one before ended. In time such readings
 * would have had a pass with each sample since. */
static integer settle(const Window *s, real *memory, double start, Solved *solved)
{
    const integer count = (integer)memory[s->memory.count];
    integer status = one_pass(s, memory, solved), passes = 1;
    for (; status == 0 && solved->kkt > FIRST_SETTLED && passes < FIRST_PASSES; passes++) {
        if (affordable(s, start) < count) {
            status = STATUS_TIME_LIMIT;
            break;
        }
        choose_points(s, 0, memory);
        memory[s->memory.stayed] = 0;
        status = one_pass(s, memory, solved);
    }
    solved->passes = passes;
    return status;
}

/* The passes of a step. */
static integer solve(const Window *s, real *memory, double start, int settles, Solved *solved)
{
#if CONVERGES
    if (s->iterate) return converge_twice(s, memory, start, solved);
#endif
    return settles ? settle(s, memory, start, solved) : one_pass(s, memory, solved);
}

/* Slide and solve. Where there is no time to make the factors of all stages that have moved, older
 * ones keep theirs; where there is none for those that have no factors there is no pass. */
static integer attempt(const Window *s, const real *given, real *memory, const Place *place,
                       real time, const real *y, double start, real *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer n_x = m->n_x, before = (integer)given[at->count];
    const integer count = place->joins ? before : before + 1 - place->drop, newest = count - 1;
    const integer most = affordable(s, start);
    const integer near = staying(s, given, place, s->reuse * s->reuse);
    const integer stays = near > count - most ? near : count - most;
    const int has_time = stays <= staying(s, given, place, INFINITY);
    slide(s, given, memory, place, time, y, stays < place->at ? stays : place->at);
    const real *rows = own_rows(s, memory, place, y);
    const int settles = is_first(s, memory, rows) && place->is_late;
    Solved solved = {NAN, 0, NAN};
    real *mean = memory + at->newest_mean, *covariance = memory + at->newest_covariance;
    integer status;
    o->reused[0] = 0;
    if (!has_time) {
        status = only_predict(s, given, memory, place, mean, covariance);
#if LAGGED
        look_back_without_pass(s, memory);
#endif
    } else {
        status = solve(s, memory, start, settles, &solved);
        if (place->joins) tell_of(s, rows);
        if (stays > near) status |= STATUS_TIME_LIMIT;
        const int is_whole = s->iterate || count == s->n_stages;
        if (status == 0 && is_whole && is_improbable(s, memory, solved.cost))
            status = STATUS_IMPROBABLE;
        copy(mean, STAGE(memory + at->x, newest, n_x), n_x);
        copy(covariance, SLOT(o->P_plus, newest, m->n_P), m->n_P);
    }
    if (!(all_finite(mean, n_x) && is_covariance(m, covariance)))
        status |= STATUS_NOT_FINITE;
    status |= remarks(m, mean, covariance, y, rows);
    report(m, &s->result, result, memory[at->times + newest], mean, covariance, o->v, o->S,
           has_time ? rows : o->nothing_present, status);
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
    memory[at->stayed] = memory[at->wait] = memory[at->apart] = 0;
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

/* A late measurement that changes nothing: it is out of reach, or brings what is not finite. */
static void refuse(const Window *s, const real *given, real *memory, integer status, real *result)
{
    const Memory *at = &s->memory;
    const integer newest = (integer)given[at->count] - 1;
    copy(memory, given, at->size);
    report_late(&s->model, &s->result, result, given[at->times + newest], given + at->newest_mean,
                given + at->newest_covariance);
    result[s->result.status] = (real)status;
#if LAGGED
    tell_lagged(s, given, 0, result);
#endif
}

void window_step(void *self, const real *given, real *memory, real time, const real *y,
                 real *result)
{
    const Window *s = self;
    const Memory *at = &s->memory;
    const double start = now(s);
    const Place place = place_of(s, given, time, y);
    if (place.at < 0) {
        refuse(s, given, memory, STATUS_LATE, result);
        result[s->result.step_time_s] = (real)(now(s) - start);
        return;
    }
    const real *inputs = place.is_late ? inputs_before(s, given, &place) : given + at->inputs;
    y = with_inputs(&s->model, inputs, y);
#if RESTS
    const integer before = (integer)given[at->count];
    const real dt = before > 0 ? time - given[at->times + before - 1] : 0;
    if (place.is_late)
        copy(memory + at->rest_told, given + at->rest_told, REST_END(&s->rest, at) - at->rest_told);
    else
        y = with_rest(&s->model, &s->rest, at, given, memory, dt, y);
#endif
    if (attempt(s, given, memory, &place, time, y, start, result) & STATUS_NOT_FINITE) {
        /* A reading so far off that its square overflows would spoil the window for N
         * steps: the instant stays, its readings go. Nothing is left of a late one. */
        if (place.is_late) {
            refuse(s, given, memory, STATUS_NOT_FINITE, result);
            result[s->result.step_time_s] = (real)(now(s) - start);
            return;
        }
        const real *nothing = without_readings(s, y);
        integer status = attempt(s, given, memory, &place, time, nothing, start, result);
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
