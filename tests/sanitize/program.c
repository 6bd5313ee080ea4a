/* Takes an export through a recording as it is, and through all that may be wrong with one; the sanitisers
 * end the program where C does what it must not. No number is NaN in silence: a step that is solved
 * has an estimate in finite numbers, whatever it was given. */
#include "pen.h"
#include "stream.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* How much of a recording is spoilt: parts of all readings, and of all measurements. */
static const struct {
    const char *name;
    double ugly, missing, odd, late;
} kinds[] = {
    {"as it is", 0, 0, 0, 0},
    {"gaps", 0, 0.5, 0, 0},
    {"nothing", 0, 1, 0, 0},
    {"late", 0, 0, 0, 0.5},
    {"a few ugly readings", 0.02, 0.1, 0, 0},
    {"ugly and late", 0.05, 0.1, 0, 0.5},
    {"many ugly readings", 0.5, 0.1, 0, 0},
    {"all ugly", 1, 0, 0, 0},
    {"odd times", 0, 0.1, 0.1, 0.1},
    {"everything", 0.1, 0.2, 0.2, 0.2},
};
static const double numbers[] = {
    NAN, INFINITY, -INFINITY, DBL_MAX, -DBL_MAX, FLT_MAX, -FLT_MAX, DBL_MIN, -DBL_MIN,
    4.9e-324, 1e-45, 0.0, -0.0, 1e200, -1e30, 1e-200, 1e8, -1e4, 3.2e9, -1.0,
};
static const double steps_s[] = {
    NAN, INFINITY, -INFINITY, 0, 0, -1e-12, 1e-12, -0.001, -0.5, -1e6, 1, 60, 1e4, 1e9, -1e300,
    1e300, 1e18, DBL_MAX, -DBL_MAX,
};

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define LENGTH 300 /* measurements after which an estimator begins again */
#define MOST_LATE 60

static pen_state states[2], before; /* two take turns */
static pen_estimate estimate;
static unsigned long long seed = 20;
static long n_steps, n_refused, n_unsolved;

static double chance(void)
{
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static size_t any(size_t n) { return (size_t)(chance() * (double)n); }

static int finite(const pen_real *a, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(a[i])) return 0;
    return 1;
}

static int take(pen_state *state, const char *kind, double time_s, const pen_real *y)
{
    before = *state;
    n_steps++;
    if (pen_step(state, time_s, y, &estimate)) {
        n_refused++;
        return memcmp(&before, state, sizeof before) == 0;
    }
    if (estimate.status & UNSOLVED) n_unsolved++;
    if (finite(estimate.mean, PEN_N_X) && finite(estimate.covariance, PEN_N_X * PEN_N_X)
        && isfinite(estimate.time_s))
        return 1;
    fprintf(stderr, "%s, step %ld at %g s: status %#x, but not finite\n", kind, n_steps, time_s,
            (unsigned)estimate.status);
    return 0;
}

/* One recording, again and again; returns whether all went well. */
static int run(size_t kind, long n)
{
    const char *name = kinds[kind].name;
    double from_s = 0;
    for (long k = 0; k < n; k++) {
        pen_state *state = &states[k & 1];
        if (k % LENGTH < 2) {
            pen_init(state);
            from_s = chance() < 0.5 ? 0 : 1e5 * chance();
        }
        const size_t row = (size_t)(k / 2 % N_ROWS), lap = (size_t)(k % LENGTH / 2 / N_ROWS);
        const double plain_s = from_s + times[row] + (double)lap * (times[N_ROWS - 1] + 0.01);
        double time_s = plain_s;
        pen_real y[PEN_N_Y], rest[PEN_N_Y];
        for (int i = 0; i < PEN_N_Y; i++) {
            y[i] = readings[row][i];
            if (chance() < kinds[kind].ugly) y[i] = (pen_real)numbers[any(COUNT(numbers))];
            if (chance() < kinds[kind].missing) y[i] = NAN;
            rest[i] = NAN;
        }
        if (chance() < kinds[kind].late && row > 0) {
            const size_t cut = any(PEN_N_Y + 1), back = 1 + any(row < MOST_LATE ? row : MOST_LATE);
            for (size_t i = cut; i < PEN_N_Y; i++) rest[i] = y[i], y[i] = NAN;
            const double late_s = plain_s - times[row] + times[row - back];
            if (!take(state, name, time_s, y) || !take(state, name, late_s, rest)) return 0;
            continue;
        }
        if (chance() < kinds[kind].odd) time_s += steps_s[any(COUNT(steps_s))];
        if (!take(state, name, time_s, y)) return 0;
        /* a jump ahead: what follows is late, or as far */
        if (time_s != plain_s && isfinite(time_s) && chance() < 0.5) from_s += time_s - plain_s;
    }
    return 1;
}

int main(void)
{
    for (size_t kind = 0; kind < COUNT(kinds); kind++)
        if (!run(kind, N_STEPS)) return 1;
    printf("%ld steps, %ld refused, %ld not solved\n", n_steps, n_refused, n_unsolved);
    return 0;
}
