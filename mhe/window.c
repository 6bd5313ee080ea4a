/* The moving horizon: slide the window onto a measurement and solve it. Behind
 * mhe/descent.c. */

/* Prior of the first stage that stays, given all readings before it: the dropped stage is
 * eliminated by one update and one prediction; see mhe/arrival_cost.py. `given` is the full
 * window; the new prior is written into `memory`. */
static void arrive(const Window *s, const double *given, double *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long n_x = m->n_x;
    const double *mean = given + s->memory.prior_mean, *P = given + s->memory.prior_covariance;
    const double *x = given + s->memory.x, *w = given + s->memory.w;
    const double *y = given + s->memory.y, *row_scale = given + s->memory.present;
    const double *noise_scale = o->unit_noises;
    double *new_mean = memory + s->memory.prior_mean;
    double *new_P = memory + s->memory.prior_covariance;
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
        double part;
        const double *seen[] = {x, y, row_scale, s->huber};
        double *weighed[] = {o->row_scale, &part};
        s->measure(seen, weighed, 0, 0, 0);
        const double *shaken[] = {w, &s->huber_noise};
        double *shaking[] = {o->noise_scale, &part};
        s->shake(shaken, shaking, 0, 0, 0);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    int at_window = s->arrival == ARRIVAL_smoothed;
    if (s->arrival == ARRIVAL_filtered) {
        double off = 0;
        const double *judged[] = {mean, x, y, row_scale};
        double *results[] = {&off};
        s->misjudge(judged, results, 0, 0, 0);
        at_window = off > s->relinearisation_limit;
    }
    const double dt = interval(s, given, 0);
    const double *x_lin = at_window ? x : mean;
    double *updated[] = {o->d_plus, o->P_plus, 0, 0, 0, 0, 0, 0};
    double *predicted[] = {o->reached, o->d_minus, new_P, 0, 0};
    difference(s, mean, x_lin, o->d_minus);
    update(m, o->d_minus, P, x_lin, y, row_scale, updated);
    if (!at_window) { /* an EKF: predict from its new mean */
        retract(m, mean, o->d_plus, o->x_try);
        memset(o->d_plus, 0, (size_t)n_x * sizeof(double));
        x_lin = o->x_try;
        w = o->no_noise;
    }
    predict(m, o->d_plus, o->P_plus, x_lin, w, &dt, noise_scale, predicted);
    retract(m, o->reached, o->d_minus, new_mean);
}

/* Copy `given` to `memory`, without its oldest stage where the window is full, and append
 * an instant whose state is predicted. */
static void slide(const Window *s, const double *given, double *memory, double time,
                  const double *y)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const long long n_x = m->n_x, n_w = m->n_w, n_y = m->n_y, n_r = m->n_r;
    const long long before = (long long)given[at->count], drop = before == s->n_stages;
    const long long kept = before - drop;
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
    memory[at->count] = (double)(kept + 1);
    memory[at->times + kept] = time;
    mark_present(m, y, STAGE(memory + at->present, kept, n_r), STAGE(memory + at->y, kept, n_y));
    double *newest = STAGE(memory + at->x, kept, n_x);
    if (before == 0)
        copy(newest, memory + at->prior_mean, n_x);
    else {
        double *noise = STAGE(memory + at->w, before - 1 - drop, n_w);
        memset(noise, 0, (size_t)n_w * sizeof(double));
        move(s, STAGE(given + at->x, before - 1, n_x), noise,
             time - given[at->times + before - 1], newest);
    }
    copy(STAGE(memory + at->predicted, kept, n_x), newest, n_x);
}

static long long attempt(const Window *s, const double *given, double *memory, double time,
                         const double *y, double *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const long long n_x = m->n_x;
    slide(s, given, memory, time, y);
    double cost = NAN, iterations = 1;
    long long status = s->iterate ? converge(s, memory, &cost, &iterations) : one_pass(s, memory);
    const long long newest = (long long)memory[at->count] - 1;
    const double *mean = STAGE(memory + at->x, newest, n_x);
    const double *covariance = STAGE(o->P_plus, newest, n_x * n_x);
    if (!(all_finite(mean, n_x) && all_finite(covariance, n_x * n_x)))
        status |= STATUS_NOT_FINITE;
    copy(memory + at->newest_mean, mean, n_x);
    copy(memory + at->newest_covariance, covariance, n_x * n_x);
    const double *present = STAGE(memory + at->present, newest, m->n_r);
    status |= remarks(m, mean, covariance, y, present);
    report(m, &s->result, result, time, mean, covariance, o->v, o->S, present, status);
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    return status;
}

void window_step(void *self, const double *given, double *memory, double time, const double *y,
                 double *result)
{
    const Window *s = self;
    const Memory *at = &s->memory;
    const double start = seconds();
    const long long before = (long long)given[at->count];
    if (before > 0 && time < given[at->times + before - 1]) {
        copy(memory, given, at->size);
        report_late(&s->model, &s->result, result, given[at->times + before - 1],
                    given + at->newest_mean, given + at->newest_covariance);
    } else if (attempt(s, given, memory, time, y, result) & STATUS_NOT_FINITE) {
        /* A reading so far off that its square overflows would spoil the window for N
         * steps: the instant stays, its readings go. */
        long long status = attempt(s, given, memory, time, s->nothing, result);
        result[s->result.status] = (double)((status & ~STATUS_NO_READING) | STATUS_NOT_FINITE);
    }
    result[s->result.step_time_s] = seconds() - start;
}

/* Converge on the window in `memory`, from the first state and the noises that it holds. */
void window_solve(void *self, double *memory, double *result)
{
    const Window *s = self;
    const long long newest = (long long)memory[s->memory.count] - 1, n_x = s->model.n_x;
    double *x = memory + s->memory.x, *w = memory + s->memory.w;
    double cost = NAN, iterations = 1;
    const double start = seconds();
    for (long long k = 0; k < newest; k++)
        move(s, STAGE(x, k, n_x), STAGE(w, k, s->model.n_w), interval(s, memory, k),
             STAGE(x, k + 1, n_x));
    const long long status = converge(s, memory, &cost, &iterations);
    copy(result + s->result.mean, STAGE(x, newest, n_x), n_x);
    copy(result + s->result.covariance, STAGE(s->work.P_plus, newest, n_x * n_x), n_x * n_x);
    result[s->result.status] = (double)status;
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    result[s->result.step_time_s] = seconds() - start;
}

int window_batch(Window *s, double *memory, double *other, long long n, const double *time,
                 const double *y, double *results)
{
    double *both[] = {memory, other};
    return batch(window_step, s, both, n, time, y, s->model.n_y, results, s->result.size);
}
