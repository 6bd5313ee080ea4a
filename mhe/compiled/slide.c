/* The window goes on to another measurement: the oldest stage becomes the prior where it is full, the
 * measurement gets a stage, or joins one. Behind mhe/compiled/late.c. */

/* How many of the oldest stages of the window to come keep their linearisation points, and with
 * them their factors: those in front of the measurement, where the estimates of all up to there have
 * moved by at most `limit`, a squared distance. None where the stage that is dropped has moved: then
 * the prior is another one. */
static integer staying(const Window *s, const real *given, const Place *place, real limit)
{
    const real *moved = given + s->memory.moved;
    const integer end = place->at + place->drop; /* what is behind the measurement is made anew */
    integer k = 0;
    if (!(s->reuse > 0)) return 0;
    while (k < end && isfinite(moved[k]) && moved[k] <= limit) k++;
    return k > place->drop ? k - place->drop : 0;
}

/* Prior of the first stage that stays, given all readings before it: the dropped stage is
 * eliminated by one update and one prediction; see mhe/arrival_cost.py. As its factors were made,
 * where `kept`: so those behind it stay as they are. `given` is the full window, `w` the noise that
 * led from its oldest stage to the first of `memory`, where the new prior is written. */
static void arrive(const Window *s, const real *given, int kept, const real *w, real *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x;
    const real *mean = given + s->memory.prior_mean, *P = given + s->memory.prior_covariance;
    const real *x = given + s->memory.x, *y = given + s->memory.y;
    const real *row_scale = given + s->memory.present;
    const real *noise_scale = o->unit_noises;
    real *new_mean = memory + s->memory.prior_mean;
    real *new_P = memory + s->memory.prior_covariance;
    if (s->arrival == ARRIVAL_none) {
        copy(new_mean, mean, n_x);
        copy(new_P, P, m->n_P);
        return;
    }
    if (s->arrival == ARRIVAL_constant) {
        copy(new_mean, memory + s->memory.predicted, n_x);
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
    const real dt = memory[s->memory.times] - given[s->memory.times];
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
    const real *u[] = {inputs_at(s, given, 0), inputs_at(s, memory, 0)};
    predict(m, d_plus, P_plus, x_lin, w, &dt, noise_scale, u, predicted);
    retract(m, o->reached, o->d_minus_prior, new_mean);
    real *deviation = memory + s->memory.prior_deviation;
    const real *first = memory + s->memory.x_lin;
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

/* Copy the stages of `given` to `memory`, without the oldest where it goes, and with room for the
 * measurement's where it has one of its own. */
static void shift(const Window *s, const real *given, real *memory, const Place *place)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_x = m->n_x, n_w = m->n_w, n_row = m->n_row, n_r = m->n_r, n_c = s->n_c;
    const integer drop = place->drop, kept = (integer)given[at->count] - drop;
    const struct { integer at, width, less; } blocks[] = {
        {at->times, 1, 0},   {at->y, n_row, 0},     {at->present, n_r, 0}, {at->x, n_x, 0},
        {at->x_lin, n_x, 0}, {at->moved, 1, 0},     {at->costate, n_x, 0}, {at->away, 1, 0},
        {at->length, 1, 0},  {at->w, n_w, 1},       {at->w_lin, n_w, 1},   {at->active, n_c, 0},
        {at->demanded, n_c, 0}, {at->predicted, n_x, 0}};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        const integer width = blocks[b].width, end = kept - blocks[b].less;
        const integer before = place->joins ? end : place->at - blocks[b].less;
        const real *from = given + blocks[b].at + drop * width;
        real *to = memory + blocks[b].at;
        if (before > 0) copy(to, from, before * width);
        if (!place->joins && end > place->at)
            copy(STAGE(to, place->at + 1, width), STAGE(from, place->at, width),
                 (end - place->at) * width);
    }
    copy(memory + at->prior_mean, given + at->prior_mean, n_x);
    copy(memory + at->prior_covariance, given + at->prior_covariance, m->n_P);
    copy(memory + at->prior_deviation, given + at->prior_deviation, n_x);
    copy(memory + at->inputs, given + at->inputs, m->n_u);
    copy(memory + at->seen, given + at->seen, m->n_sensors);
    memory[at->wait] = given[at->wait];
    memory[at->apart] = given[at->apart];
    memory[at->count] = (real)(place->joins ? kept : kept + 1);
}

/* Put a measurement into `memory`, which follows `given`: an instant of its own, predicted, or readings
 * of one that is there. The first `stays` stages keep their factors. */
static void slide(const Window *s, const real *given, real *memory, const Place *place, real time,
                  const real *y, integer stays)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const integer n_x = m->n_x, n_w = m->n_w, k = place->at, last = k + place->drop - 1;
    shift(s, given, memory, place);
    s->work.told[0] = k;
    if (place->joins)
        join(s, memory, k, y);
    else {
        real *x = STAGE(memory + at->x, k, n_x);
        const real *w = given + at->w;
        memory[at->times + k] = time;
        take_readings(s, memory, k, y);
        if (place->is_late) {
            put_between(s, given, memory, place);
            if (k == 0) w = s->work.w_late;
        } else {
            copy(memory + at->inputs, y + m->n_y, m->n_u);
            if (last < 0)
                copy(x, memory + at->prior_mean, n_x);
            else {
                real *noise = STAGE(memory + at->w, k - 1, n_w);
                memset(noise, 0, (size_t)n_w * sizeof(real));
                move(s, memory, k - 1, STAGE(given + at->x, last, n_x), noise, x);
            }
        }
        keep_inside(s, x);
        copy(STAGE(memory + at->predicted, k, n_x), x, n_x);
        if (place->drop) arrive(s, given, stays > 0, w, memory);
    }
    choose_points(s, stays, memory);
    memory[at->stayed] = (real)stays;
}

