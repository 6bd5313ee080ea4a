/* Whether a body rests: the detector of estimation/rest.py, where its rule is written down. Its
 * state are the blocks rest_... of an estimator's. Behind the declarations of Memory and Rest. */
#if RESTS

#define REST_END(r, at) ((at)->rest_square + (REST_BLOCKS + 1) * (r)->n)
#define REST_AT(name, block) (memory + at->name + (block) * r->n)

/* Take the blocks from `first` to before `end` together, for one axis: number, mean, sum of
 * squared deviations. */
static void rest_join(const Rest *r, const Memory *at, const real *memory, integer axis,
                      integer first, integer end, real joined[3])
{
    real n = REST_AT(rest_n, first)[axis], mean = REST_AT(rest_mean, first)[axis];
    real square = REST_AT(rest_square, first)[axis];
    for (integer k = first + 1; k < end; k++) {
        const real more = REST_AT(rest_n, k)[axis];
        if (!(more > 0)) continue;
        const real both = n + more, apart = REST_AT(rest_mean, k)[axis] - mean;
        mean = mean + apart * more / both;
        square = square + REST_AT(rest_square, k)[axis] + apart * apart * n * more / both;
        n = both;
    }
    joined[0] = n;
    joined[1] = mean;
    joined[2] = square;
}

/* Close the block that is being filled; the oldest goes where there are enough. */
static void rest_close(const Rest *r, const Memory *at, real *memory)
{
    if (memory[at->rest_closed] < REST_BLOCKS) {
        memory[at->rest_closed] += 1;
        return;
    }
    const struct { integer at, width; } blocks[] = {
        {at->rest_age, 1}, {at->rest_n, r->n}, {at->rest_mean, r->n}, {at->rest_square, r->n}};
    for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
        real *block = memory + blocks[b].at;
        const integer size = REST_BLOCKS * blocks[b].width;
        memmove(block, block + blocks[b].width, (size_t)size * sizeof(real));
        memset(block + size, 0, (size_t)blocks[b].width * sizeof(real));
    }
}

/* Put readings into the block that is being filled; returns whether rest may go on. */
static int rest_take(const Model *m, const Rest *r, const Memory *at, real *memory, real dt,
                     const real *y)
{
    int present = 0, disturbed = 0;
    memory[at->rest_since] += dt;
    for (integer i = 0; i < r->n; i++) {
        const real reading = y[r->column[i]];
        if (isnan(reading)) continue;
        present = 1;
        if (!(fabs(reading) < m->saturation[r->column[i]])) disturbed = 1;
    }
    if (!present) return 0;
    if (disturbed || memory[at->rest_since] > r->gap_s) {
        const integer window = REST_END(r, at) - at->rest_closed;
        memset(memory + at->rest_closed, 0, (size_t)window * sizeof(real));
    }
    const integer block = (integer)memory[at->rest_closed];
    real *age = memory + at->rest_age + block;
    *age += memory[at->rest_since];
    memory[at->rest_since] = 0;
    if (disturbed) return 0;
    for (integer i = 0; i < r->n; i++) {
        const real reading = y[r->column[i]];
        if (isnan(reading)) continue;
        real *n = REST_AT(rest_n, block) + i, *mean = REST_AT(rest_mean, block) + i;
        const real away = reading - *mean;
        *n += 1;
        *mean += away / *n;
        REST_AT(rest_square, block)[i] += away * (reading - *mean);
    }
    if (*age >= r->block_s) rest_close(r, at, memory);
    return 1;
}

/* Whether the blocks and the newest readings are those of a still body, with a rate that may be
 * bias. The axes' means go to r->mean. */
static int is_still(const Rest *r, const Memory *at, const real *memory, const real *y)
{
    if (memory[at->rest_closed] < REST_BLOCKS) return 0;
    for (integer g = 0; g < r->n_gyroscopes; g++) r->turn[g] = -r->largest_square[g];
    for (integer i = 0; i < r->n; i++) {
        real a[3], b[3];
        rest_join(r, at, memory, i, 0, REST_BLOCKS / 2, a);
        rest_join(r, at, memory, i, REST_BLOCKS / 2, REST_BLOCKS + 1, b);
        if (a[0] < REST_FEWEST || b[0] < REST_FEWEST) return 0;
        const real n = r->number[i] = a[0] + b[0], apart = b[1] - a[1];
        const real variance = r->noise_std[i] * r->noise_std[i];
        const real mean = r->mean[i] = a[1] + apart * b[0] / n;
        const real square = a[2] + b[2] + apart * apart * a[0] * b[0] / n;
        const real chance = (real)REST_HALVES * (real)REST_HALVES * (1 / a[0] + 1 / b[0]);
        const real spread = r->spread_factor * r->spread_factor * variance;
        const real reading = y[r->column[i]], away = isnan(reading) ? 0 : reading - mean;
        if (!(square < spread * (n - 1))) return 0;
        if (!(square > 0) && !r->may_repeat[i]) return 0;
        if (!(apart * apart < (chance > 1 ? chance : 1) * variance)) return 0;
        if (!(away * away < (real)REST_NEWEST * (real)REST_NEWEST * spread)) return 0;
        if (r->gyroscope[i] >= 0)
            r->turn[r->gyroscope[i]] +=
                mean * mean - (real)REST_HALVES * (real)REST_HALVES * variance / n;
    }
    for (integer g = 0; g < r->n_gyroscopes; g++)
        if (!(r->turn[g] < 0)) return 0;
    return 1;
}

/* Whether the still body's rate is that of the last rest, but for what biases walk. */
static int is_known(const Rest *r, const Memory *at, const real *memory)
{
    for (integer g = 0; g < r->n_gyroscopes; g++) r->apart[g] = 0;
    for (integer i = 0; i < r->n; i++) {
        if (r->gyroscope[i] < 0) continue;
        const real n = r->number[i], variance = r->noise_std[i] * r->noise_std[i];
        const real apart = r->mean[i] - memory[at->rest_bias + i];
        r->apart[r->gyroscope[i]] +=
            apart * apart - 2 * (real)REST_HALVES * (real)REST_HALVES * variance / n
            - r->walk_square[i] * memory[at->rest_ago];
    }
    for (integer g = 0; g < r->n_gyroscopes; g++)
        if (!(r->apart[g] < 0)) return 0;
    return 1;
}

/* Whether the body rests, `dt` after the measurement before. */
static int rests(const Rest *r, const Memory *at, real *memory, real dt, const real *y)
{
    if (!is_still(r, at, memory, y)) {
        memory[at->rest_waits] = 0;
        return 0;
    }
    if (memory[at->rest_known] != 0 && !is_known(r, at, memory)) {
        memory[at->rest_waits] += dt;
        if (!(memory[at->rest_waits] > r->patience_s)) return 0;
    }
    memory[at->rest_known] = 1;
    memory[at->rest_ago] = memory[at->rest_waits] = 0;
    copy(memory + at->rest_bias, r->mean, r->n);
    return 1;
}

/* Follow the readings of a measurement `dt` after the one before; returns them with that of rest.
 * The rest_... blocks of `given` go to `memory`. */
static const real *with_rest(const Model *m, const Rest *r, const Memory *at, const real *given,
                             real *memory, real dt, const real *y)
{
    int turns = 0;
    copy(memory + at->rest_told, given + at->rest_told, REST_END(r, at) - at->rest_told);
    memory[at->rest_ago] += dt;
    copy(r->y, y, m->n_row);
    const int still = rest_take(m, r, at, memory, dt, y);
    for (integer i = 0; i < r->count; i++)
        if (isfinite(y[r->first + i])) memory[at->rest_told] = 1;
    for (integer i = 0; i < r->n; i++)
        if (r->gyroscope[i] >= 0 && !isnan(y[r->column[i]])) turns = 1;
    if (memory[at->rest_told] == 0 && turns && still && rests(r, at, memory, dt, y))
        for (integer i = 0; i < r->count; i++) r->y[r->first + i] = 0;
    return r->y;
}

#endif
