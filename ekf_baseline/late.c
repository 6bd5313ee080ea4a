/* Late readings: a log of the last rows in order of capture, and the filter's state at every
 * `spacing`-th of them. A late row is put where it belongs, and what followed is made again.
 * Behind ekf_baseline/filter.c.
 *
 * The first `own` numbers of a state are the filter's, the blocks from `count` on its log, which may
 * be in another array, `kept`: times[0] is that of the state before the first row, checkpoint j the
 * state before row j * spacing. */

#define OWN (f->memory.count)
#define KEPT(block) (kept + f->memory.block)
#define COUNT ((integer)*KEPT(count))
#define ROW_AT(k) (KEPT(rows) + (k) * f->model.n_row)
#define CHECKPOINT(j) (KEPT(checkpoints) + (j) * OWN)

static void copy_log(const Filter *f, const real *given, real *kept)
{
    const Memory *at = &f->memory;
    if (f->capacity == 0) return;
    const integer n = (integer)given[at->count], made = (n + f->spacing - 1) / f->spacing;
    *KEPT(count) = given[at->count];
    copy(KEPT(times), given + at->times, n + 1);
    copy(KEPT(steps), given + at->steps, n);
    copy(KEPT(rows), given + at->rows, n * f->model.n_row);
    copy(KEPT(checkpoints), given + at->checkpoints, made * OWN);
}

/* Move what the log has of rows from `first` to before the newest by some rows. */
static void move_rows(const Filter *f, real *kept, integer first, integer by)
{
    const integer n_row = f->model.n_row;
    const size_t moved = (size_t)(COUNT - first) * sizeof(real);
    memmove(KEPT(times) + 1 + first + by, KEPT(times) + 1 + first, moved);
    memmove(KEPT(steps) + first + by, KEPT(steps) + first, moved);
    memmove(ROW_AT(first + by), ROW_AT(first), moved * (size_t)n_row);
    *KEPT(count) += (real)by;
}

/* The oldest rows leave a full log, up to the next checkpoint. */
static void forget(const Filter *f, real *kept)
{
    const integer s = f->spacing, left = f->capacity / s - 1;
    KEPT(times)[0] = KEPT(times)[s];
    memmove(CHECKPOINT(0), CHECKPOINT(1), (size_t)(left * OWN) * sizeof(real));
    move_rows(f, kept, s, -s);
}

/* Log a row behind all others; `given` is the state before it. */
static void append(const Filter *f, const real *given, real *kept, real time, real dt,
                   const real *y)
{
    if (f->capacity == 0) return;
    if (COUNT == f->capacity) forget(f, kept);
    const integer n = COUNT;
    if (n == 0) KEPT(times)[0] = given[f->memory.time_s];
    if (n % f->spacing == 0) copy(CHECKPOINT(n / f->spacing), given, OWN);
    KEPT(times)[n + 1] = time;
    KEPT(steps)[n] = dt;
    copy(ROW_AT(n), y, f->model.n_row);
    *KEPT(count) += 1;
}

/* Whether readings and inputs may stand in one row with others. */
static int may_join(const Model *m, const real *row, const real *y)
{
    for (integer i = 0; i < m->n_row; i++)
        if (!isnan(row[i]) && !isnan(y[i]) && (i < m->n_y || row[i] != y[i])) return 0;
    return 1;
}

/* Put readings into a row; `told` are the rows of the residual that they bring. */
static void join(const Filter *f, real *row, const real *y)
{
    const Model *m = &f->model;
    mark_present(m, row, f->used, f->clean);
    for (integer i = 0; i < m->n_row; i++)
        if (isnan(row[i])) row[i] = y[i];
    mark_present(m, row, f->told, f->clean);
    for (integer r = 0; r < m->n_r; r++)
        if (f->used[r] != 0) f->told[r] = 0;
}

/* Log a late row where it belongs; returns its place, or -1 where it is older than the log. */
static integer insert(const Filter *f, real *kept, real time, const real *y)
{
    const Model *m = &f->model;
    const integer count = f->capacity > 0 ? COUNT : 0;
    const real *times = KEPT(times) + 1;
    integer place = count;
    if (count == 0 || times[-1] >= time - SAME_S) return -1;
    while (place > 0 && times[place - 1] > time + SAME_S) place--;
    for (integer k = place - 1; k >= 0 && times[k] >= time - SAME_S; k--)
        if (may_join(m, ROW_AT(k), y)) {
            join(f, ROW_AT(k), y);
            return k;
        }
    while (place > 0 && times[place - 1] > time) place--;
    for (integer i = m->n_y; place == 0 && i < m->n_row; i++) /* before all that is known of it */
        if (!isfinite(y[i]) && !isfinite(CHECKPOINT(0)[f->memory.inputs + i - m->n_y])) return -1;
    if (count == f->capacity) {
        if (place < f->spacing) return -1;
        forget(f, kept);
        place -= f->spacing;
    }
    move_rows(f, kept, place, 1);
    KEPT(times)[place + 1] = time;
    KEPT(steps)[place] = isnan(times[place - 1]) ? 0 : time - times[place - 1];
    KEPT(steps)[place + 1] = times[place + 1] - time;
    copy(ROW_AT(place), y, m->n_row);
    for (integer r = 0; r < m->n_r; r++) f->told[r] = 1;
    return place;
}

/* Keep what the workspace has of a late row: its innovations, without those of others that stood
 * there. Returns whether any was gated. */
static int keep_innovations(const Filter *f)
{
    const Model *m = &f->model;
    int gated = 0;
    copy(f->late_v, f->v, m->n_r);
    copy(f->late_S, f->S, m->n_r * m->n_r);
    for (integer r = 0; r < m->n_r; r++) {
        if (f->present[r] == 0) f->told[r] = 0;
        f->late_used[r] = f->told[r] != 0 ? f->used[r] : 0;
        gated = gated || (f->told[r] != 0 && f->late_used[r] == 0);
        if (f->told[r] != 0) continue;
        for (integer c = 0; c < m->n_r; c++)
            f->late_S[r * m->n_r + c] = f->late_S[c * m->n_r + r] = 0;
        f->late_S[r * (m->n_r + 1)] = m->noise_std[r] * m->noise_std[r];
    }
    return gated;
}

/* Make the states from the log's row `late` on again; `memory` is then the newest. Returns the status
 * but for remarks, that of the late row and of the newest one. */
static integer replay(const Filter *f, real *kept, real *memory, integer late, integer *updates)
{
    const integer s = f->spacing, count = COUNT;
    const real *from = CHECKPOINT(late / s);
    real lost = 0;
    integer status = 0, found = 0, made = 0;
    for (integer row = late / s * s; row < count; row++) {
        const integer next = row + 1;
        real *to = (count - next) % 2 == 0 ? memory : f->other;
        if (next < count && next % s == 0) to = CHECKPOINT(next / s);
        *f->model.lost = 0;
        found = advance(f, from, to, KEPT(steps)[row], ROW_AT(row), &made);
        to[f->memory.time_s] = KEPT(times)[next];
        if (row == late) {
            status = found & ~STATUS_GATED;
            if (keep_innovations(f)) status |= STATUS_GATED;
            lost = *f->model.lost;
            *updates = made;
        }
        from = to;
    }
    if (lost != 0) *f->model.lost = lost;
    return status | (found & ~STATUS_GATED);
}

/* Take a measurement: the state `given` becomes `memory`, the log changes in place. */
static void take(const Filter *f, const real *given, real *memory, real *kept, real time,
                 const real *y, real *result)
{
    const Model *m = &f->model;
    const Memory *at = &f->memory;
    const double start = seconds();
    const real before = given[at->time_s], dt = isnan(before) ? 0 : time - before;
    const real *mean = memory + at->mean, *covariance = memory + at->covariance;
    const real *v = f->v, *S = f->S, *present = f->present, *used = f->used;
    integer status, updates = 1;
    if (dt < 0) {
        const integer late = insert(f, kept, time, y);
        if (late < 0) {
            copy(memory, given, OWN);
            report_late(m, &f->result, result, before, mean, covariance);
            result[f->result.step_time_s] = (real)(seconds() - start);
            return;
        }
        status = replay(f, kept, memory, late, &updates);
        v = f->late_v, S = f->late_S, present = f->told, used = f->late_used;
    } else {
        status = advance(f, given, memory, dt, y, &updates);
        memory[at->time_s] = time;
        append(f, given, kept, time, dt, y);
    }
    status |= remarks(m, mean, covariance, y, used);
    report(m, &f->result, result, memory[at->time_s], mean, covariance, v, S, present, status);
    result[f->result.iterations] = (real)updates;
    result[f->result.step_time_s] = (real)(seconds() - start);
}

void filter_step(void *self, const real *given, real *memory, real time, const real *y,
                 real *result)
{
    const Filter *f = self;
    copy_log(f, given, memory);
    take(f, given, memory, memory, time, y, result);
}

/* A whole recording: the log stays in the first of both states until the last measurement. */
int filter_batch(Filter *f, real *memory, real *other, integer n, const real *time,
                 const real *y, real *results)
{
    real *both[] = {memory, other};
    int at = 0;
    for (integer k = 0; k < n; k++, at = !at)
        take(f, both[at], both[!at], memory, time[k], y + k * f->model.n_row,
             results + k * f->result.size);
    if (at) copy_log(f, memory, other);
    return at;
}
