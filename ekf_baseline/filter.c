/* The extended Kalman filter: predict to a measurement's time, update with what it has.
 * Behind estimation/engine.c; the structures Memory and Filter are declared in front. */

/* Entry of the covariance that may come on top of some rows of S: `more` of `added`, or of the noise. */
static real added_to(const Filter *f, const real *added, integer i, integer j)
{
    const Model *m = &f->model;
    if (added) return added[f->rows[i] + m->n_r * f->rows[j]];
    return i == j ? m->noise_std[f->rows[i]] * m->noise_std[f->rows[i]] : 0;
}

/* Squared Mahalanobis distance d2 of some rows of an innovation, `count` of them, with `more` of
 * something on top of S: the lower triangle in L, in z what `slope_of` begins with. */
static real squared_distance(const Filter *f, const real *S, const real *added, integer count,
                             real more)
{
    const integer n_r = f->model.n_r, *rows = f->rows;
    real sum = 0, *L = f->L, *z = f->z;
    for (integer i = 0; i < count; i++) {
        real left = f->v[rows[i]];
        for (integer j = 0; j <= i; j++) {
            real s = S[rows[i] + n_r * rows[j]];
            if (more > 0) s += more * added_to(f, added, i, j);
            for (integer k = 0; k < j; k++) s -= L[i * count + k] * L[j * count + k];
            L[i * count + j] = i == j ? sqrt(s) : s / L[j * count + j];
        }
        for (integer j = 0; j < i; j++) left -= L[i * count + j] * z[j];
        z[i] = left / L[i * count + i];
        sum += z[i] * z[i];
    }
    return sum;
}

/* By how much d2 falls with `more`, behind `squared_distance`. */
static real slope_of(const Filter *f, const real *added, integer count)
{
    real slope = 0, *L = f->L, *z = f->z;
    for (integer i = count - 1; i >= 0; i--) {
        for (integer j = i + 1; j < count; j++) z[i] -= L[j * count + i] * z[j];
        z[i] /= L[i * count + i];
    }
    for (integer i = 0; i < count; i++)
        for (integer j = 0; j < count; j++) slope += z[i] * added_to(f, added, i, j) * z[j];
    return slope;
}

/* How much of something has to come on top of S for a d2 of at most `most`; 0 where none has to, or
 * no number says. */
static real needed(const Filter *f, const real *S, const real *added, integer count, real most)
{
    real more = 0;
    for (integer step = 0; step < NEWTON_STEPS; step++) {
        const real s = squared_distance(f, S, added, count, more);
        if (!(s > most * (1 + NEWTON_SETTLED))) break;
        more += s / slope_of(f, added, count) * (s / most - 1);
        if (!isfinite(more)) return 0;
    }
    return more;
}

/* Those rows of a sensor, into `rows`, of which `there` is not zero; returns how many. */
static integer rows_of(const Filter *f, integer sensor, const real *there)
{
    const Model *m = &f->model;
    integer count = 0;
    for (integer row = m->first_row[sensor]; row < m->first_row[sensor + 1]; row++)
        if (there[row] != 0) f->rows[count++] = row;
    return count;
}

/* Whether only the prior speaks against a sensor's readings: none was ever used. */
static int is_new(const Filter *f, const real *given, integer sensor)
{
    const Model *m = &f->model;
    return m->measured_rows[m->first_row[sensor]] && given[f->memory.seen + sensor] == 0;
}

/* Take the rows of sensors whose readings are too far off out of `used`; `opens` are those that would
 * be, but whose gate has rejected so many in a row that the state is doubted. */
static int gate(const Filter *f, const real *given, real *memory, real dt)
{
    const integer n_r = f->model.n_r, n_sensors = f->model.n_sensors;
    int rejected = 0;
    for (integer sensor = 0; sensor < n_sensors; sensor++) {
        real *doubt = memory + f->memory.doubt + 2 * sensor; /* rejected in a row, and for how long */
        f->opens[sensor] = 0;
        if (doubt[0] > 0) doubt[1] += dt;
        const integer count = rows_of(f, sensor, f->present);
        if (count == 0) continue;
        const real limit = f->gate[sensor * (n_r + 1) + count];
        const int is_far = squared_distance(f, f->S, 0, count, 0) > limit;
        if (!is_far || is_new(f, given, sensor)) {
            doubt[0] = doubt[1] = 0;
        } else if (doubt[0] >= GATE_REJECTIONS && doubt[1] >= GATE_DOUBT_S) {
            doubt[0] = doubt[1] = 0;
            f->opens[sensor] = 1;
        } else {
            doubt[0] += 1;
            for (integer i = 0; i < count; i++) f->used[f->rows[i]] = 0;
            rejected = 1;
        }
    }
    return rejected;
}

/* Where gates open, make the prior less certain by as much of the model's own prior as it takes for
 * their readings to be as far off as one expects, all of it at most; S_wide is its innovation
 * covariance. Whether any gate opens. */
static int widen(const Filter *f)
{
    const Model *m = &f->model;
    const integer n = m->n_r * m->n_r;
    real *known[] = {0, 0, 0, f->S_wide, 0, 0, 0, 0}, share = 0;
    int opened = 0;
    for (integer sensor = 0; sensor < m->n_sensors; sensor++) opened |= f->opens[sensor] != 0;
    if (!opened) return 0;
    copy(f->P_wide, f->P_minus, m->n_P);
    add_covariance(m, f->P_wide, 1, f->prior_P);
    update(m, f->no_deviation, f->P_wide, f->x_minus, f->clean, f->present, known);
    for (integer i = 0; i < n; i++) f->S_added[i] = f->S_wide[i] - f->S[i];
    for (integer sensor = 0; sensor < m->n_sensors; sensor++) {
        if (f->opens[sensor] == 0) continue;
        const integer count = rows_of(f, sensor, f->present);
        if (squared_distance(f, f->S_wide, 0, count, 0) > (real)count) share = 1;
        if (share < 1) share = fmax(share, needed(f, f->S, f->S_added, count, (real)count));
    }
    add_covariance(m, f->P_minus, fmin(share, 1), f->prior_P);
    update(m, f->no_deviation, f->P_minus, f->x_minus, f->clean, f->present, known);
    return 1;
}

/* Give readings that are too far off less weight in `used`; see ekf_baseline/outliers.py. */
static int bound(const Filter *f, const real *given, const real *S)
{
    int bounded = 0;
    for (integer sensor = 0; sensor < f->model.n_sensors; sensor++) {
        const integer count = rows_of(f, sensor, f->used);
        if (count == 0 || is_new(f, given, sensor)) continue;
        const real more = needed(f, S, 0, count, f->huber[sensor] * f->huber[sensor]);
        if (!(more > 0)) continue;
        for (integer i = 0; i < count; i++) f->used[f->rows[i]] = sqrt(1 / (1 + more));
        bounded = 1;
    }
    return bounded;
}

/* Whether a sensor's readings are used that never were; it counts as seen then. */
static int is_first(const Filter *f, const real *given, real *memory)
{
    const Model *m = &f->model;
    const real *before = given + f->memory.seen;
    real *seen = memory + f->memory.seen;
    int first = 0;
    copy(seen, before, m->n_sensors);
    for (integer sensor = 0; sensor < m->n_sensors; sensor++)
        for (integer row = m->first_row[sensor]; row < m->first_row[sensor + 1]; row++)
            if (f->used[row] != 0 && m->measured_rows[row]) seen[sensor] = 1;
    for (integer sensor = 0; sensor < m->n_sensors; sensor++)
        first = first || seen[sensor] != before[sensor];
    return first;
}

/* Linearise an update at its own posterior, again and again until that stays: the prior is the
 * same each time. A posterior that stays at once is kept as it is. Returns the number of updates. */
static integer settle(const Filter *f, integer most, real *mean, real *covariance)
{
    const Model *m = &f->model;
    const integer n_x = m->n_x;
    const real *away[] = {mean, f->x_minus};
    real *from_prior[] = {f->d_minus};
    real *moved[] = {f->d_plus, 0, 0, 0, 0, 0, 0, 0}, *known[] = {0, covariance, 0, 0, 0, 0, 0, 0};
    integer updates = 1;
    for (; updates < most; updates++) {
        real largest = 0;
        call(m, &f->difference, away, from_prior);
        for (integer i = 0; i < n_x; i++) f->d_minus[i] = -f->d_minus[i];
        update(m, f->d_minus, f->P_minus, mean, f->clean, f->used, moved);
        if (!all_finite(f->d_plus, n_x)) break;
        for (integer i = 0; i < n_x; i++)
            largest = fmax(largest, fabs(f->d_plus[i]) / sqrt(variance(m, covariance, i)));
        if (!(largest > FIRST_SETTLED)) break;
        update(m, f->d_minus, f->P_minus, mean, f->clean, f->used, known);
        retract(m, mean, f->d_plus, f->x_next);
        copy(mean, f->x_next, n_x);
    }
    return updates;
}

/* From the state `given` to that of a measurement `dt` later: all of `memory` but its time. Returns
 * the status but for remarks; innovations and what was used are left in the workspace. */
static integer advance(const Filter *f, const real *given, real *memory, real dt, const real *y,
                       integer *updates)
{
    const Model *m = &f->model;
    const Memory *at = &f->memory;
    const integer n_x = m->n_x;
    integer status = 0;
    *updates = 1;
    y = with_inputs(m, given + at->inputs, y);
    copy(memory + at->inputs, y + m->n_y, m->n_u);
#if RESTS
    y = with_rest(m, &f->rest, at, given, memory, dt, y);
#endif
    const real *reached = memory + at->inputs;
    const real *u[] = {isnan(given[at->time_s]) ? reached : given + at->inputs, reached};
    mark_present(m, y, f->present, f->clean);
    copy(f->used, f->present, m->n_r);
    real *predicted[] = {f->x_minus, 0, f->P_minus, 0, 0};
    predict(m, f->no_deviation, given + at->covariance, given + at->mean, f->no_noise, &dt,
            f->unit_noise, u, predicted);
    retract(m, f->x_minus, f->no_deviation, f->x_minus); /* angles within a turn */
    real *mean = memory + at->mean, *covariance = memory + at->covariance;
    real *updated[] = {f->d_plus, covariance, f->v, f->S, 0, 0, 0, 0};
    update(m, f->no_deviation, f->P_minus, f->x_minus, f->clean, f->present, updated);
    int changed = 0, doubted = 0;
    copy(memory + at->doubt, given + at->doubt, 2 * m->n_sensors);
    if (f->gate) {
        if (gate(f, given, memory, dt)) status |= STATUS_GATED;
        doubted = widen(f);
        changed = doubted || (status & STATUS_GATED);
    }
    if (f->huber && bound(f, given, doubted ? f->S_wide : f->S)) changed = 1;
    if (changed) {
        real *again[] = {f->d_plus, covariance, 0, 0, 0, 0, 0, 0};
        update(m, f->no_deviation, f->P_minus, f->x_minus, f->clean, f->used, again);
    }
    retract(m, f->x_minus, f->d_plus, mean);
    real *settling = memory + at->settling_s;
    const int first = is_first(f, given, memory);
    *settling = first ? SETTLING_S : fmax(given[at->settling_s] - dt, 0);
    if (*settling > 0 || doubted)
        *updates = settle(f, first || doubted ? FIRST_UPDATES : SETTLING_UPDATES, mean, covariance);
    if (!(all_finite(mean, n_x) && is_covariance(m, covariance))) {
        const int predicts = all_finite(f->x_minus, n_x) && is_covariance(m, f->P_minus);
        status |= STATUS_NOT_FINITE; /* the last rung: the last estimate stays */
        copy(mean, predicts ? f->x_minus : given + at->mean, n_x);
        copy(covariance, predicts ? f->P_minus : given + at->covariance, m->n_P);
        copy(memory + at->seen, given + at->seen, m->n_sensors);
        *settling = given[at->settling_s];
        copy(memory + at->doubt, given + at->doubt, 2 * m->n_sensors);
    }
    return status;
}
