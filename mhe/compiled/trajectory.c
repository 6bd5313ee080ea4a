/* A window's trajectory: roll it out, and what it costs. Behind estimation/engine.c and a form of
 * its stage; the structures Memory, Work and Window are declared in front.
 *
 * `memory` is the state: stages oldest first, `count` of them. */

#define STAGE(array, k, width) ((array) + (k) * (width))

static void difference(const Window *s, const real *to, const real *from, real *delta)
{
    const real *arguments[] = {to, from};
    real *results[] = {delta};
    call(&s->model, &s->difference, arguments, results);
}

static real interval(const Window *s, const real *memory, integer k)
{
    const real *times = memory + s->memory.times;
    return times[k + 1] - times[k];
}

/* Inputs of a stage, behind its readings. */
static const real *inputs_at(const Window *s, const real *memory, integer k)
{
    return STAGE(memory + s->memory.y, k, s->model.n_row) + s->model.n_y;
}

/* f(x, w) of a step, with the inputs at both of its ends. */
static void move_on(const Window *s, real dt, const real *const u[2], const real *x, const real *w,
                    real *reached)
{
    const real *arguments[] = {x, w, &dt, u[0], u[1]};
    real *results[] = {reached};
    call(&s->model, &s->move, arguments, results);
}

/* f(x, w) of the step behind stage k. */
static void move(const Window *s, const real *memory, integer k, const real *x, const real *w,
                 real *reached)
{
    const real *u[] = {inputs_at(s, memory, k), inputs_at(s, memory, k + 1)};
    move_on(s, interval(s, memory, k), u, x, w, reached);
}

#if CONVERGES
/* Cost of readings and noises of a trajectory, and the scales by which its losses weigh
 * them; the prior's part is the caller's. */
static real measure(const Window *s, const real *memory, const real *x, const real *w,
                      real *row_scale, real *noise_scale)
{
    const Model *m = &s->model;
    const integer count = (integer)memory[s->memory.count];
    const real *y = memory + s->memory.y, *present = memory + s->memory.present;
    real cost = 0, part = 0;
    for (integer k = 0; k < count; k++) {
        const real *seen[] = {STAGE(x, k, m->n_x), STAGE(y, k, m->n_row),
                                STAGE(present, k, m->n_r), s->huber};
        real *scales[] = {STAGE(row_scale, k, m->n_r), &part};
        call(&s->model, &s->measure, seen, scales);
        cost += part;
    }
    for (integer k = 0; k + 1 < count; k++) {
        const real *shaken[] = {STAGE(w, k, m->n_w), &s->huber_noise};
        real *scales[] = {STAGE(noise_scale, k, m->n_w), &part};
        call(&s->model, &s->shake, shaken, scales);
        cost += part;
    }
    return cost;
}
#endif

/* x becomes the nearest point inside the bounds of the states that add. */
static void keep_inside(const Window *s, real *x)
{
    for (integer i = 0; s->n_c > 0 && i < s->model.n_x; i++) {
        if (x[i] < s->lower[i]) x[i] = s->lower[i];
        if (x[i] > s->upper[i]) x[i] = s->upper[i];
    }
}

/* Whether chance can hardly explain the cost of a minimum; see mhe/second_start.py. */
static int is_improbable(const Window *s, const real *memory, real cost)
{
    const integer n_rows = (integer)memory[s->memory.count] * s->model.n_r;
    const real *present = memory + s->memory.present;
    integer seen = 0;
    for (integer i = 0; i < n_rows; i++) seen += present[i] != 0;
    return cost > s->cost_limits[seen];
}

/* What solving a window says beside its trajectory: cost (NaN where nobody counts it), passes,
 * and how far it is from the optimality conditions. */
typedef struct {
    real cost, passes, kkt;
} Solved;
