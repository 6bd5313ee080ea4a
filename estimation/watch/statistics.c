/* The statistics of estimation/watch/statistics.py, in its order, to the last bit: behind the
 * structures Watch (where blocks of the memory begin) and Statistics. Sensor i has the rows
 * first_row[i] to before first_row[i + 1] of a residual; those that are not watched have no limits. */
#include <math.h>
#include <string.h>


/* Whether a sensor's reading is, in all axes, the one that is remembered from `block` on. */
static int is_again(const real *y, const real *block, integer first, integer end)
{
    for (integer c = first; c < end; c++)
        if (!(y[c] == block[c])) return 0;
    return 1;
}

/* Take the readings of an instant into the memory; returns whether a sensor is stuck, and says
 * in `stuck` of which. */
static int repeats(const Statistics *s, real *memory, real time_s, const real *y,
                   unsigned char *stuck)
{
    const Watch *at = &s->watch;
    real *last = memory + at->last, *before_last = memory + at->before_last;
    int any = 0;
    for (integer i = 0; i < s->n_sensors; i++) {
        const integer first = s->first_column[i], end = s->first_column[i + 1];
        int present = s->is_watched[i] && s->repeats[i] > 0;
        if (stuck) stuck[i] = 0;
        for (integer c = first; c < end; c++) present = present && isfinite(y[c]);
        if (!present) continue;
        if (is_again(y, last, first, end) || is_again(y, before_last, first, end)) {
            real *count = memory + at->repeats + i, *when = memory + at->repeated_s + i;
            if (!(time_s - *when <= REPEATS_S)) *count = 0;
            *count += 1;
            *when = time_s;
            if (*count >= s->repeats[i]) {
                any = 1;
                if (stuck) stuck[i] = 1;
            }
        }
        int is_clipped = 0;
        for (integer c = first; c < end; c++) {
            real *same = memory + at->same + c;
            *same = y[c] == last[c] ? *same + 1 : 0;
            is_clipped = is_clipped || *same >= s->same[i];
            before_last[c] = last[c];
            last[c] = y[c];
        }
        if (is_clipped) {
            any = 1;
            if (stuck) stuck[i] = 1;
        }
    }
    return any;
}

/* z and d2 by its limit of each sensor, NaN where there is no reading. */
static void distances(const Statistics *s, const real *v, const real *S)
{
    const integer n_r = s->n_r;
    real *L = s->L;
    for (integer r = 0; r < n_r; r++) s->z[r] = NAN;
    for (integer i = 0; i < s->n_sensors; i++) {
        real squared = 0;
        integer count = 0;
        s->far[i] = NAN;
        if (!s->is_watched[i]) continue;
        for (integer r = s->first_row[i]; r < s->first_row[i + 1]; r++) {
            if (isnan(v[r])) continue;
            real left = v[r], *row = L + count * n_r;
            for (integer j = 0; j < count; j++) {
                real of_S = S[r * n_r + s->rows[j]];
                for (integer k = 0; k < j; k++) of_S -= row[k] * L[j * n_r + k];
                row[j] = of_S / L[j * n_r + j];
            }
            real of_S = S[r * n_r + r];
            for (integer k = 0; k < count; k++) {
                of_S -= row[k] * row[k];
                left -= row[k] * s->z[s->rows[k]];
            }
            row[count] = of_S > 0 ? sqrt(of_S) : NAN;
            s->z[r] = left / row[count];
            squared += s->z[r] * s->z[r];
            s->rows[count++] = r;
        }
        if (count) s->far[i] = squared / s->squared[s->first_row[i] + count - 1];
    }
}

/* Take an instant's z into the memory. */
static void take_sample(const Statistics *s, real *memory, const real *z)
{
    const Watch *at = &s->watch;
    const integer n = s->n_sensors, n_r = s->n_r;
    for (integer i = 0; i < n; i++) {
        const integer first = s->first_row[i], end = s->first_row[i + 1];
        real squared = 0, count = 0;
        if (!s->is_watched[i]) continue;
        for (integer r = first; r < end; r++) {
            if (isnan(z[r])) continue;
            squared += z[r] * z[r];
            count += 1;
        }
        if (!(count > 0)) continue;
        squared /= count;
        for (integer w = 0; w < s->windows; w++) {
            const real a = s->weights[i * s->windows + w], b = 1 - a;
            real *mean = memory + at->mean + w * n_r;
            real *energy = memory + at->energy + w * n + i;
            for (integer r = first; r < end; r++)
                if (!isnan(z[r])) mean[r] = b * mean[r] + a * z[r];
            *energy = b * *energy + a * squared;
        }
        const real a = s->weights[i * s->windows];
        const real much = LIVELIER * s->usual[2 * s->windows * i + s->windows];
        real *busy = memory + at->busy + i;
        *busy = (1 - a) * *busy + a * (squared > much ? 1 : 0);
        memory[at->samples + i] += 1;
    }
}

/* Whether a sensor's sample is an outlier beside those before it. */
static int is_outlier(const Statistics *s, const real *memory, const real *far, integer i)
{
    const integer windows = s->windows;
    const real usual = s->usual[2 * windows * i + windows];
    return far[i] > 1 && memory[s->watch.samples + i] > 0
           && far[i] > memory[s->watch.energy + i] / usual;
}

/* A sensor's mean score and its energy over a window, of its limits. */
static real mean_share(const Statistics *s, const real *memory, integer i, integer w)
{
    const Watch *at = &s->watch;
    const real a = s->weights[i * s->windows + w];
    const real *mean = memory + at->mean + w * s->n_r;
    real squared = 0;
    for (integer r = s->first_row[i]; r < s->first_row[i + 1]; r++) squared += mean[r] * mean[r];
    return squared * (2 - a) / a / s->limit[2 * s->windows * i + w];
}

static real energy_share(const Statistics *s, const real *memory, integer i, integer w)
{
    const integer windows = s->windows;
    return memory[s->watch.energy + w * s->n_sensors + i] / s->limit[2 * windows * i + windows + w];
}

/* The largest share of its limits that a sensor has. */
static real score_of(const Statistics *s, const real *memory, integer i)
{
    real score = memory[s->watch.outliers + i] / s->outliers[i];
    for (integer w = 0; w < s->windows; w++) {
        const real mean = mean_share(s, memory, i, w), energy = energy_share(s, memory, i, w);
        if (mean > score) score = mean;
        if (energy > score) score = energy;
    }
    return score;
}
