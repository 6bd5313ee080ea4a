/* A second descent where a minimum is doubtful; mhe/second_start.py says when and where it begins.
 * Behind mhe/compiled/descent.c. */

/* Whether a bound or an inequality holds the window's trajectory. */
static int is_held_back(const Window *s, const real *memory)
{
    const integer n_rows = (integer)memory[s->memory.count] * s->n_c;
    for (integer i = 0; i < n_rows; i++)
        if (memory[s->memory.active + i] != 0) return 1;
    return 0;
}

/* The states behind the first one follow from it and the noises. */
static void roll_out(const Window *s, real *memory)
{
    const integer n_x = s->model.n_x;
    real *x = memory + s->memory.x;
    for (integer k = 0; k + 1 < (integer)memory[s->memory.count]; k++)
        move(s, memory, k, STAGE(x, k, n_x), STAGE(memory + s->memory.w, k, s->model.n_w),
             STAGE(x, k + 1, n_x));
}

/* The trajectory without noise from a first state beside the prior's mean and inside all bounds. */
static void start_beside(const Window *s, real *memory)
{
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const integer newest = (integer)memory[at->count] - 1, n_x = s->model.n_x;
    const real *P = memory + at->prior_covariance;
    real *x = memory + at->x;
    for (integer i = 0; i < n_x; i++) o->d_try[i] = ASIDE * sqrt(variance(&s->model, P, i));
    retract(&s->model, memory + at->prior_mean, o->d_try, x);
    for (integer i = 0; i < n_x; i++) {
        const real lower = s->lower[i], upper = s->upper[i];
        const real room = fmin(sqrt(variance(&s->model, P, i)), (upper - lower) / 2);
        x[i] = fmin(fmax(x[i], lower + room), upper - room);
    }
    memset(memory + at->w, 0, (size_t)(newest * s->model.n_w) * sizeof(real));
    roll_out(s, memory);
    memory[at->apart] = 0;
    memset(memory + at->active, 0, (size_t)((newest + 1) * s->n_c) * sizeof(real));
}

/* Whether there is reason for a second start; `status` is how the first one ended. */
static int is_doubtful(const Window *s, real *memory, integer status, real cost)
{
    real *wait = memory + s->memory.wait;
    if (status) return (status & STATUS_SOLVER_FAILED) != 0;
    if (*wait > 0) {
        (*wait)--;
        return 0;
    }
    return is_improbable(s, memory, cost) || is_held_back(s, memory);
}

/* Whether the second start's end is the better one. */
static int is_better(const Window *s, integer again, real cost, integer status, real than)
{
    const real margin = LOWER * fmax(1, than);
    if (again) return s->n_c == 0 && !(again & STATUS_NOT_FINITE) && cost < than - margin;
    return status ? cost <= than + margin : cost < than - margin;
}

/* Converge, and where the minimum is doubtful once more from another start: the lower one stays.
 * In a full window a start that was of no use is followed by the next N samples later. */
static integer converge_twice(const Window *s, real *memory, double start, Solved *solved)
{
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const Model *m = &s->model;
    const integer status = converge(s, memory, start, solved);
    const integer count = (integer)memory[at->count], n_r = m->n_r;
#if LAGGED
    look_back(s, memory); /* what is told stays the first one's unless the second is better */
#endif
    if (!is_doubtful(s, memory, status, solved->cost)) return status;
    if (affordable(s, start) < count) return status;
    const struct { real *kept, *from; integer size; } parts[] = {
        {o->x_first, memory + at->x, count * m->n_x},
        {o->w_first, memory + at->w, (count - 1) * m->n_w},
        {o->active_first, memory + at->active, count * s->n_c},
        {o->apart_first, memory + at->apart, 1},
        {o->P_newest, SLOT(o->P_plus, count - 1, m->n_P), m->n_P},
        {o->v_first, o->v, n_r},
        {o->S_first, o->S, n_r * n_r}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        copy(parts[i].kept, parts[i].from, parts[i].size);
    Solved other = {NAN, solved->passes, NAN};
    start_beside(s, memory);
    const integer again = converge(s, memory, start, &other);
    solved->passes = other.passes;
    if (is_better(s, again, other.cost, status, solved->cost)) {
        *solved = other;
#if LAGGED
        look_back(s, memory);
#endif
        return again;
    }
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        copy(parts[i].from, parts[i].kept, parts[i].size);
    o->ring[MADE] = 0;
    if (status == 0 && count == s->n_stages) memory[at->wait] = (real)(count - 1);
    return status;
}

/* Converge on the window in `memory`, from the first state and the noises that it holds. */
void window_solve(void *self, real *memory, real *result)
{
    const Window *s = self;
    const integer newest = (integer)memory[s->memory.count] - 1, n_x = s->model.n_x;
    const real *x = memory + s->memory.x;
    Solved solved = {NAN, 0, NAN};
    const double start = now(s);
    roll_out(s, memory);
    s->work.told[0] = newest;
    integer status = converge_twice(s, memory, start, &solved);
    if (status == 0 && is_improbable(s, memory, solved.cost)) status = STATUS_IMPROBABLE;
    copy(result + s->result.mean, STAGE(x, newest, n_x), n_x);
    covariance_of(&s->model, SLOT(s->work.P_plus, newest, s->model.n_P),
                  result + s->result.covariance);
    result[s->result.status] = (real)status;
    result[s->result.iterations] = solved.passes;
    result[s->result.cost] = solved.cost;
    result[s->result.kkt] = solved.kkt;
    result[s->result.reused] = 0;
    result[s->result.step_time_s] = (real)(now(s) - start);
}
