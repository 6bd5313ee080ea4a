/* The moving horizon: slide the window onto a measurement and solve it. Behind
 * mhe/descent.c. */

/* Prior of the first stage that stays, given all readings before it: the dropped stage is
 * eliminated by one update and one prediction; see mhe/arrival_cost.py. `given` is the full
 * window; the new prior is written into `memory`. */
static void arrive(const Window *s, const real *given, real *memory)
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
        copy(new_P, P, n_x * n_x);
        return;
    }
    if (s->arrival == ARRIVAL_constant) {
        copy(new_mean, STAGE(given + s->memory.predicted, 1, n_x), n_x);
        copy(new_P, s->constant_covariance, n_x * n_x);
        return;
    }
    if (s->has_losses) {
        real part;
        const real *seen[] = {x, y, row_scale, s->huber};
        real *weighed[] = {o->row_scale, &part};
        s->measure(seen, weighed, 0, 0, 0);
        const real *shaken[] = {w, &s->huber_noise};
        real *shaking[] = {o->noise_scale, &part};
        s->shake(shaken, shaking, 0, 0, 0);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    int at_window = s->arrival == ARRIVAL_smoothed;
    if (s->arrival == ARRIVAL_filtered) {
        real off = 0;
        const real *judged[] = {mean, x, y, row_scale};
        real *results[] = {&off};
        s->misjudge(judged, results, 0, 0, 0);
        at_window = off > s->relinearisation_limit;
    }
    const real dt = interval(s, given, 0);
    const real *x_lin = at_window ? x : mean;
    real *updated[] = {o->d_plus, o->P_plus, 0, 0, 0, 0, 0, 0};
    real *predicted[] = {o->reached, o->d_minus, new_P, 0, 0};
    difference(s, mean, x_lin, o->d_minus);
    update(m, o->d_minus, P, x_lin, y, row_scale, updated);
    if (!at_window) { /* an EKF: predict from its new mean */
        retract(m, mean, o->d_plus, o->x_try);
        memset(o->d_plus, 0, (size_t)n_x * sizeof(real));
        x_lin = o->x_try;
        w = o->no_noise;
    }
    predict(m, o->d_plus, o->P_plus, x_lin, w, &dt, noise_scale, predicted);
    retract(m, o->reached, o->d_minus, new_mean);
}

/* Copy `given` to `memory`, without its oldest stage where the window is full, and append
 * an instant whose state is predicted. */
static void slide(const Window *s, const real *given, real *memory, real time,
                  const real *y)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_x = m->n_x, n_w = m->n_w, n_y = m->n_y, n_r = m->n_r;
    const integer before = (integer)given[at->count], drop = before == s->n_stages;
    const integer kept = before - drop;
    copy(memory + at->times, given + at->times + drop, kept);
    copy(memory + at->y, given + at->y + drop * n_y, kept * n_y);
    copy(memory + at->present, given + at->present + drop * n_r, kept * n_r);
    copy(memory + at->x, given + at->x + drop * n_x, kept * n_x);
    copy(memory + at->predicted, given + at->predicted + drop * n_x, kept * n_x);
    if (kept > 0) copy(memory + at->w, given + at->w + drop * n_w, (kept - 1) * n_w);
    if (drop)
        arrive(s, given, memory);
    else {
        copy(memory + at->prior_mean, given + at->prior_mean, n_x);
        copy(memory + at->prior_covariance, given + at->prior_covariance, n_x * n_x);
    }
    memory[at->count] = (real)(kept + 1);
    memory[at->times + kept] = time;
    mark_present(m, y, STAGE(memory + at->present, kept, n_r), STAGE(memory + at->y, kept, n_y));
    real *newest = STAGE(memory + at->x, kept, n_x);
    if (before == 0)
        copy(newest, memory + at->prior_mean, n_x);
    else {
        real *noise = STAGE(memory + at->w, before - 1 - drop, n_w);
        memset(noise, 0, (size_t)n_w * sizeof(real));
        move(s, STAGE(given + at->x, before - 1, n_x), noise,
             time - given[at->times + before - 1], newest);
    }
    copy(STAGE(memory + at->predicted, kept, n_x), newest, n_x);
}

static integer attempt(const Window *s, const real *given, real *memory, real time,
                         const real *y, real *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer n_x = m->n_x;
    slide(s, given, memory, time, y);
    real cost = NAN, iterations = 1;
    integer status = s->iterate ? converge(s, memory, &cost, &iterations) : one_pass(s, memory);
    const integer newest = (integer)memory[at->count] - 1;
    const real *mean = STAGE(memory + at->x, newest, n_x);
    const real *covariance = STAGE(o->P_plus, newest, n_x * n_x);
    if (!(all_finite(mean, n_x) && all_finite(covariance, n_x * n_x)))
        status |= STATUS_NOT_FINITE;
    copy(memory + at->newest_mean, mean, n_x);
    copy(memory + at->newest_covariance, covariance, n_x * n_x);
    const real *present = STAGE(memory + at->present, newest, m->n_r);
    status |= remarks(m, mean, covariance, y, present);
    report(m, &s->result, result, time, mean, covariance, o->v, o->S, present, status);
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    return status;
}

void window_step(void *self, const real *given, real *memory, real time, const real *y,
                 real *result)
{
    const Window *s = self;
    const Memory *at = &s->memory;
    const real start = seconds();
    const integer before = (integer)given[at->count];
    if (before > 0 && time < given[at->times + before - 1]) {
        copy(memory, given, at->size);
        report_late(&s->model, &s->result, result, given[at->times + before - 1],
                    given + at->newest_mean, given + at->newest_covariance);
    } else if (attempt(s, given, memory, time, y, result) & STATUS_NOT_FINITE) {
        /* A reading so far off that its square overflows would spoil the window for N
         * steps: the instant stays, its readings go. */
        integer status = attempt(s, given, memory, time, s->nothing, result);
        result[s->result.status] = (real)((status & ~STATUS_NO_READING) | STATUS_NOT_FINITE);
    }
    result[s->result.step_time_s] = seconds() - start;
}

/* Converge on the window in `memory`, from the first state and the noises that it holds. */
void window_solve(void *self, real *memory, real *result)
{
    const Window *s = self;
    const integer newest = (integer)memory[s->memory.count] - 1, n_x = s->model.n_x;
    real *x = memory + s->memory.x, *w = memory + s->memory.w;
    real cost = NAN, iterations = 1;
    const real start = seconds();
    for (integer k = 0; k < newest; k++)
        move(s, STAGE(x, k, n_x), STAGE(w, k, s->model.n_w), interval(s, memory, k),
             STAGE(x, k + 1, n_x));
    const integer status = converge(s, memory, &cost, &iterations);
    copy(result + s->result.mean, STAGE(x, newest, n_x), n_x);
    copy(result + s->result.covariance, STAGE(s->work.P_plus, newest, n_x * n_x), n_x * n_x);
    result[s->result.status] = (real)status;
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    result[s->result.step_time_s] = seconds() - start;
}

int window_batch(Window *s, real *memory, real *other, integer n, const real *time,
                 const real *y, real *results)
{
    real *both[] = {memory, other};
    return batch(window_step, s, both, n, time, y, s->model.n_y, results, s->result.size);
}
