/* Where a measurement goes in a window: behind the newest stage, or where it is late at its capture;
 * mhe/late.py is the same in Python. Behind mhe/compiled/one_pass.c. */

typedef struct {
    integer at;   /* its stage in the window to come; below 0 where that is out of reach */
    integer drop; /* how many of the oldest stages go */
    int is_late, joins;
} Place;

/* Whether a stage has a reading: one that no row present needs counts as missing. */
static int is_there(const Window *s, const real *memory, integer k, integer reading)
{
    const Model *m = &s->model;
    const real *present = STAGE(memory + s->memory.present, k, m->n_r);
    for (integer row = 0; row < m->n_r; row++)
        if (present[row] != 0 && m->row_needs[row * m->n_y + reading]) return 1;
    return 0;
}

/* Whether a stage has none of a measurement's readings. */
static int has_room(const Window *s, const real *memory, integer k, const real *y)
{
    for (integer i = 0; i < s->model.n_y; i++)
        if (isfinite(y[i]) && is_there(s, memory, k, i)) return 0;
    return 1;
}

static Place place_of(const Window *s, const real *given, real time, const real *y)
{
    const real *times = given + s->memory.times;
    const integer before = (integer)given[s->memory.count];
    Place place = {before, before == s->n_stages, 0, 0};
    while (place.at > 0 && times[place.at - 1] > time) place.at--;
    place.is_late = place.at < before;
    integer k = place.at;
    while (k < before - 1 && times[k] <= time + SAME_S) k++;
    for (k--; place.is_late && k >= 0 && times[k] >= time - SAME_S; k--)
        if (has_room(s, given, k, y)) {
            const Place joined = {k, 0, 1, 1};
            return joined;
        }
    place.at -= place.drop;
    return place;
}

/* The inputs of the instant that a late measurement is at or behind; the first stage's before it. */
static const real *inputs_before(const Window *s, const real *given, const Place *place)
{
    const integer at = place->joins ? place->at : place->at + place->drop - 1;
    return inputs_at(s, given, at > 0 ? at : 0);
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

/* The readings of a measurement join those of stage k. */
static void join(const Window *s, real *memory, integer k, const real *y)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_y = m->n_y, n_c = s->n_c;
    real *row = s->work.joined, *demanded = STAGE(memory + at->demanded, k, n_c);
    copy(row, y, m->n_row);
    for (integer i = 0; i < n_y; i++)
        if (!isfinite(y[i]))
            row[i] = is_there(s, memory, k, i) ? STAGE(memory + at->y, k, m->n_row)[i] : NAN;
    copy(s->work.row_try, demanded, n_c);
    take_readings(s, memory, k, row);
    for (integer j = 0; j < n_c; j++) demanded[j] = fmax(demanded[j], s->work.row_try[j]);
}

/* The state at the capture of a late measurement whose readings `memory` holds, and the noises on both
 * sides of it: those that led over the whole step, in proportion to the times. In front of the first
 * stage it is that one's state. */
static void put_between(const Window *s, const real *given, real *memory, const Place *place)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_x = m->n_x, n_w = m->n_w, k = place->at, behind = k + place->drop;
    const real *times = given + at->times, time = memory[at->times + k];
    real *x = STAGE(memory + at->x, k, n_x), *w = memory + at->w, *first = s->work.w_late;
    memory[at->apart] = 1;
    if (behind == 0) {
        copy(x, given + at->x, n_x);
        memset(w, 0, (size_t)n_w * sizeof(real));
        return;
    }
    const real dt = times[behind] - times[behind - 1], part = (time - times[behind - 1]) / dt;
    const real *whole = STAGE(given + at->w, behind - 1, n_w);
    for (integer i = 0; i < n_w; i++) {
        first[i] = sqrt(part) * whole[i];
        STAGE(w, k, n_w)[i] = sqrt(1 - part) * whole[i];
    }
    if (k > 0) copy(STAGE(w, k - 1, n_w), first, n_w);
    const real *u[] = {inputs_at(s, given, behind - 1), inputs_at(s, memory, k)};
    move_on(s, time - times[behind - 1], u, STAGE(given + at->x, behind - 1, n_x), first, x);
}
