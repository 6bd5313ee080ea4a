/* The extended Kalman filter: predict to a measurement's time, update with what it has.
 * Behind estimation/engine.c; the structures Memory and Filter are declared in front. */

/* Squared Mahalanobis distance of some rows of an innovation; `count` rows, at most n_r. */
static real squared_distance(const real *v, const real *S, integer n_r,
                               const integer *rows, integer count, real *L, real *z)
{
    real sum = 0;
    for (integer i = 0; i < count; i++) {
        real left = v[rows[i]];
        for (integer j = 0; j <= i; j++) {
            real s = S[rows[i] + n_r * rows[j]];
            for (integer k = 0; k < j; k++) s -= L[i * count + k] * L[j * count + k];
            L[i * count + j] = i == j ? sqrt(s) : s / L[j * count + j];
        }
        for (integer j = 0; j < i; j++) left -= L[i * count + j] * z[j];
        z[i] = left / L[i * count + i];
        sum += z[i] * z[i];
    }
    return sum;
}

/* Take the rows of sensors whose readings are too far off out of `used`. */
static int gate(const Filter *f)
{
    const Model *m = &f->model;
    int rejected = 0;
    for (integer sensor = 0; sensor < m->n_sensors; sensor++) {
        integer *rows = f->rows, count = 0;
        for (integer row = m->first_row[sensor]; row < m->first_row[sensor + 1]; row++)
            if (f->present[row] != 0) rows[count++] = row;
        if (count == 0) continue;
        real distance = squared_distance(f->v, f->S, m->n_r, rows, count, f->L, f->z);
        if (!(distance > f->gate[count])) continue;
        for (integer i = 0; i < count; i++) f->used[rows[i]] = 0;
        rejected = 1;
    }
    return rejected;
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
static integer settle(const Filter *f, real *mean, real *covariance)
{
    const Model *m = &f->model;
    const integer n_x = m->n_x;
    const real *away[] = {mean, f->x_minus};
    real *from_prior[] = {f->d_minus};
    real *moved[] = {f->d_plus, 0, 0, 0, 0, 0, 0, 0}, *known[] = {0, covariance, 0, 0, 0, 0, 0, 0};
    integer updates = 1;
    for (; updates < FIRST_UPDATES; updates++) {
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
    if (f->gate && gate(f)) {
        status |= STATUS_GATED;
        real *again[] = {f->d_plus, covariance, 0, 0, 0, 0, 0, 0};
        update(m, f->no_deviation, f->P_minus, f->x_minus, f->clean, f->used, again);
    }
    retract(m, f->x_minus, f->d_plus, mean);
    if (is_first(f, given, memory)) *updates = settle(f, mean, covariance);
    if (!(all_finite(mean, n_x) && is_covariance(m, covariance))) {
        const int predicts = all_finite(f->x_minus, n_x) && is_covariance(m, f->P_minus);
        status |= STATUS_NOT_FINITE; /* the last rung: the last estimate stays */
        copy(mean, predicts ? f->x_minus : given + at->mean, n_x);
        copy(covariance, predicts ? f->P_minus : given + at->covariance, m->n_P);
        copy(memory + at->seen, given + at->seen, m->n_sensors);
    }
    return status;
}
