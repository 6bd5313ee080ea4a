/* Instants in which nothing stands out, for estimation/watch/quiet.py. Behind statistics.c. */

/* Take an instant as `Statistics.clean` does; returns whether nothing stands out. */
static int is_clean(const Statistics *s, real *memory, int is_late, real time_s, const real *y,
                    const real *v, const real *S)
{
    if (!is_late && repeats(s, memory, time_s, y, 0)) return 0;
    distances(s, v, S);
    for (integer i = 0; i < s->n_sensors; i++)
        if (s->is_watched[i] && is_outlier(s, memory, s->far, i)) return 0;
    take_sample(s, memory, s->z);
    for (integer i = 0; i < s->n_sensors; i++)
        if (s->is_watched[i] && !isnan(s->far[i])) memory[s->watch.outliers + i] = 0;
    for (integer i = 0; i < s->n_sensors; i++)
        if (s->is_watched[i] && score_of(s, memory, i) > 1) return 0;
    return 1;
}

/* Whether all inertial sensors would be usual, were their energy larger by a factor. */
static int is_calm(const Statistics *s, const real *memory, real factor)
{
    const integer slow = s->windows - 1, n = s->n_sensors;
    for (integer i = 0; i < n; i++) {
        const real energy = memory[s->watch.energy + slow * n + i];
        if (s->is_inertial[i] && !(factor * energy <= s->usual[2 * s->windows * i + s->windows + slow]))
            return 0;
    }
    return 1;
}

/* As `watch_clean`, one instant that is not late, of n_x states: from one memory to another. Returns
 * whether nothing stands out, and each state with a limit is known where it was, and only there. */
integer watch_one(const Statistics *s, const real *before, real *memory, real time_s,
                  const real *y, const real *v, const real *S, integer n_x, const real *P,
                  const real *limit, const real *known, const real *std_before, real *std,
                  real since_s, real after_s, real factor);
integer watch_one(const Statistics *s, const real *before, real *memory, real time_s,
                  const real *y, const real *v, const real *S, integer n_x, const real *P,
                  const real *limit, const real *known, const real *std_before, real *std,
                  real since_s, real after_s, real factor)
{
    int is_sure = 1;
    for (integer i = 0; i < n_x; i++) {
        std[i] = sqrt(P[i * n_x + i]);
        if (isnan(limit[i])) continue;
        is_sure = is_sure && (std[i] < limit[i]) == (known[i] != 0)
                  && (std_before[i] < limit[i]) == (known[i] != 0);
    }
    if (!is_sure) return 0;
    memcpy(memory, before, (size_t)s->watch.size * sizeof(real));
    return is_clean(s, memory, 0, time_s, y, v, S)
           && !(factor > 0 && !(time_s - since_s < after_s) && is_calm(s, memory, factor));
}

/* Take n instants up to the first in which something stands out; returns how many. With a factor
 * above 0 calm does, too, after so long. The arrays of two instants are as far apart as is said. */
integer watch_clean(const Statistics *s, real *memory, real newest_s, integer n,
                    const real *time_s, const real *y, const real *v, integer next_v,
                    const real *S, integer next_S, real since_s, real after_s, real factor);
integer watch_clean(const Statistics *s, real *memory, real newest_s, integer n,
                    const real *time_s, const real *y, const real *v, integer next_v,
                    const real *S, integer next_S, real since_s, real after_s, real factor)
{
    const size_t size = (size_t)s->watch.size * sizeof(real);
    for (integer k = 0; k < n; k++) {
        memcpy(s->before, memory, size);
        if (!is_clean(s, memory, time_s[k] < newest_s, time_s[k], y + k * s->n_row,
                      v + k * next_v, S + k * next_S)
            || (factor > 0 && !(time_s[k] - since_s < after_s) && is_calm(s, memory, factor))) {
            memcpy(memory, s->before, size);
            return k;
        }
        if (time_s[k] > newest_s) newest_s = time_s[k];
    }
    return n;
}

/* Take n samples into a memory; returns the largest score of the sensors that are judged, behind those
 * that count, where there are as many samples at least. */
real watch_again(const Statistics *s, real *memory, integer n, const real *v, integer next_v,
                 const real *S, integer next_S, const unsigned char *counts,
                 const unsigned char *judged, real fewest);
real watch_again(const Statistics *s, real *memory, integer n, const real *v, integer next_v,
                 const real *S, integer next_S, const unsigned char *counts,
                 const unsigned char *judged, real fewest)
{
    real most = 0;
    for (integer k = 0; k < n; k++) {
        distances(s, v + k * next_v, S + k * next_S);
        take_sample(s, memory, s->z);
        for (integer i = 0; counts[k] && i < s->n_sensors; i++) {
            if (!judged[i] || memory[s->watch.samples + i] < fewest) continue;
            const real score = score_of(s, memory, i);
            if (score > most) most = score;
        }
    }
    return most;
}
