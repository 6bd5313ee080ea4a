/* A watch that no replay helps, for exports: it says what Python's says, and leaves out a sensor
 * that alone stands out. Behind statistics.c and an estimator's loop; the structure Alone (where
 * blocks of the watch begin) is declared in front.
 *
 * A sensor is left out while it stands out and no other does, and taken back when a while of its
 * readings fits again what the others say. Where several stand out none is blamed: the estimate is
 * inconsistent. Where all inertial sensors have more energy than is usual, the motion is livelier. */

/* Forget a sensor's samples, its repeats aside. */
static void forget_samples(const Statistics *s, real *memory, integer i)
{
    const Watch *at = &s->watch;
    memory[at->samples + i] = memory[at->outliers + i] = memory[at->busy + i] = 0;
    for (integer w = 0; w < s->windows; w++) {
        memory[at->energy + w * s->n_sensors + i] = 0;
        for (integer r = s->first_row[i]; r < s->first_row[i + 1]; r++)
            memory[at->mean + w * s->n_r + r] = 0;
    }
}

/* Whether a sensor's energy is above its limit. */
static int is_energetic(const Statistics *s, const real *memory, integer i)
{
    for (integer w = 0; w < s->windows; w++)
        if (memory[s->watch.energy + w * s->n_sensors + i]
            > s->limit[2 * s->windows * i + s->windows + w])
            return 1;
    return 0;
}

/* Whether nothing else stands out but the energy of inertial sensors; see
 * estimation/watch/energy.py, for this and the next. */
static int is_only_energy(const Statistics *s, const real *memory, const unsigned char *flagged)
{
    for (integer i = 0; i < s->n_sensors; i++) {
        if (!s->is_watched[i] || (flagged[i] & FLAG_LEFT_OUT)) continue;
        if (memory[s->watch.outliers + i] >= s->outliers[i]) return 0;
        for (integer w = 0; w < s->windows; w++) {
            const real energy = energy_share(s, memory, i, w);
            if (mean_share(s, memory, i, w) > (energy > 1 ? energy : 1)) return 0;
        }
        if (!s->is_inertial[i] && is_energetic(s, memory, i)) return 0;
    }
    return 1;
}

/* Whether it looks as if the body moves more than its model says. */
static int is_livelier(const Statistics *s, const real *memory, const unsigned char *flagged)
{
    const integer windows = s->windows;
    int all = 1, any = 0, all_busy = 1, energetic = 0;
    for (integer i = 0; i < s->n_sensors; i++) {
        if (!s->is_watched[i] || (flagged[i] & FLAG_LEFT_OUT)) continue;
        if (is_energetic(s, memory, i)) {
            energetic = 1;
            all_busy = all_busy && memory[s->watch.busy + i] > BUSY;
        }
        if (!s->is_inertial[i]) continue;
        real most = 0;
        for (integer w = 0; w < windows; w++) {
            const real share = memory[s->watch.energy + w * s->n_sensors + i]
                               / s->usual[2 * windows * i + windows + w];
            if (share > most) most = share;
        }
        any = 1;
        all = all && most > 1;
    }
    return (any && all) || (is_only_energy(s, memory, flagged) && energetic && all_busy);
}

/* Take readings of the sensors with some flags out of a row; whether there were any. */
static int take_out(const Statistics *s, const unsigned char *flagged, int flags, real *y)
{
    int any = 0;
    for (integer i = 0; i < s->n_sensors; i++)
        for (integer c = s->first_column[i]; (flagged[i] & flags) && c < s->first_column[i + 1]; c++) {
            any = any || !isnan(y[c]);
            y[c] = NAN;
        }
    return any;
}

/* Is what was known known still? Returns whether the state is lost. */
static int is_lost(const Statistics *s, const Alone *at, real *watch, const real *covariance,
                   integer n_x)
{
    int found_all = 1, any_lost = 0;
    real *lost = watch + at->lost, *known = watch + at->known;
    for (integer i = 0; i < n_x; i++) {
        const real std = sqrt(covariance[i * (n_x + 1)]);
        if (isnan(s->found_std[i])) continue;
        if (known[i] > 0) {
            if (!(std < s->found_std[i])) found_all = 0;
            if (std > s->lost_std[i]) any_lost = 1;
        }
        if (std < s->found_std[i]) known[i] = 1;
    }
    *lost = *lost > 0 ? !found_all : any_lost;
    return *lost > 0;
}

/* Taken back when all that is remembered of it, for long enough, fits. */
static void return_or_wait(const Statistics *s, real *memory, real *out_s, integer i, real time)
{
    const real score = score_of(s, memory, i);
    if (score > 1) {
        forget_samples(s, memory, i);
        *out_s = time;
    } else if (time - *out_s >= RETURN_S && score < RETURNS
               && memory[s->watch.samples + i] >= FEWEST_SAMPLES) {
        *out_s = NAN;
    }
}

/* What follows from the statistics of an instant; returns bits of the status. */
static integer judge_sensors(const Statistics *s, const Alone *at, real *watch, real time,
                      unsigned char *flagged)
{
    real *memory = watch + at->memory, *alarm_s = watch + at->alarm_s;
    integer count = 0, kept = 0, blamed = -1;
    for (integer i = 0; i < s->n_sensors; i++) {
        real *out_s = watch + at->out_s + i;
        if (!s->is_watched[i]) continue;
        if (flagged[i] & FLAG_LEFT_OUT) {
            return_or_wait(s, memory, out_s, i, time);
            continue;
        }
        kept++;
        if (!(score_of(s, memory, i) > 1)) continue;
        count++;
        blamed = i;
    }
    if (count == 0) {
        *alarm_s = NAN;
        return 0;
    }
    if (is_livelier(s, memory, flagged)) return STATUS_LIVELIER;
    if (is_only_energy(s, memory, flagged)) { /* a motion that begins is soon told from a fault */
        if (isnan(*alarm_s)) *alarm_s = time;
        if (time - *alarm_s < WAIT_S) return 0;
    }
    if (count == 1 && kept > 1) {
        watch[at->out_s + blamed] = time;
        flagged[blamed] |= FLAG_INCONSISTENT | FLAG_LEFT_OUT;
        forget_samples(s, memory, blamed);
        *alarm_s = NAN;
        return 0;
    }
    for (integer i = 0; i < s->n_sensors; i++)
        if (s->is_watched[i] && !(flagged[i] & FLAG_LEFT_OUT) && score_of(s, memory, i) > 1)
            flagged[i] |= FLAG_INCONSISTENT;
    return STATUS_INCONSISTENT;
}

/* A step of an estimator, watched: without what is stuck, an outlier, or left out. A second step is
 * made where the first, which says how far readings are off, has used what is not to be used. */
static void watched_step(step_function step, void *self, const Statistics *s, const Alone *at,
                         const Result *r, integer n_x, const real *given, real *memory, real *watch,
                         int late, real time, real *y, real *result, unsigned char *flagged)
{
    real *own = watch + at->memory;
    integer status = 0;
    memset(flagged, 0, (size_t)s->n_sensors);
    if (!late && repeats(s, own, time, y, flagged)) status |= STATUS_STUCK;
    for (integer i = 0; i < s->n_sensors; i++) {
        flagged[i] = flagged[i] ? FLAG_STUCK : 0;
        if (!isnan(watch[at->out_s + i])) flagged[i] |= FLAG_INCONSISTENT | FLAG_LEFT_OUT;
    }
    if (isnan(watch[at->begun_s])) watch[at->begun_s] = time;
    const int is_calm = time - watch[at->begun_s] < CALM_S;
    take_out(s, flagged, FLAG_STUCK, y);
    step(self, given, memory, time, y, result);
    distances(s, result + r->innovation, result + r->innovation_covariance);
    for (integer i = 0; i < s->n_sensors && !is_calm; i++) {
        if (!s->is_watched[i] || !is_outlier(s, own, s->far, i)) continue;
        flagged[i] |= FLAG_OUTLIER;
        status |= STATUS_OUTLIER;
        for (integer row = s->first_row[i]; row < s->first_row[i + 1]; row++) s->z[row] = NAN;
    }
    if (take_out(s, flagged, FLAG_OUTLIER | FLAG_LEFT_OUT, y))
        step(self, given, memory, time, y, result);
    take_sample(s, own, s->z);
    for (integer i = 0; i < s->n_sensors; i++)
        if (s->is_watched[i] && !isnan(s->far[i]))
            own[s->watch.outliers + i] = flagged[i] & FLAG_OUTLIER ? own[s->watch.outliers + i] + 1 : 0;
    if (!is_calm) status |= judge_sensors(s, at, watch, time, flagged);
    if (is_lost(s, at, watch, result + r->covariance, n_x)) status |= STATUS_LOST;
    result[r->status] = (real)((integer)result[r->status] | status);
}
