/* A step that must be answered in time. Behind mhe/compiled/active_set.c.
 *
 * Before every pass the clock is asked whether one more would end in time, going by how long
 * passes took of late: their running mean per stage whose factors are made, and for safety half as
 * much again or four times their mean deviation, whichever is more (Jacobson 1988, Congestion
 * avoidance and control). A single longer one (the processor was elsewhere) counts as twice the
 * mean, the next in a row as four times, and so on. */

#define NEWEST_SHARE 0.1
#define LARGEST 2
#define SAFETY 1.5
#define DEVIATIONS 4
#define HOPE 0.95
#define BESIDE 2 /* stages: what a pass takes beside its factors */
#define MEAN 0
#define MOST 1
#define SPREAD 2

static double now(const Window *s)
{
    return s->clock ? ((double (*)(void))(void (*)(void))s->clock)() : seconds();
}

static int is_timed(const Window *s) { return TIMED && isfinite(s->deadline); }

/* Of how many stages a pass can make the factors in time; below 1 of none. */
static integer affordable(const Window *s, double start)
{
    if (!is_timed(s)) return s->n_stages;
    const double left = (double)s->deadline - (now(s) - start);
    const double mean = (double)s->work.pass_time[MEAN];
    const double each = fmax(SAFETY * mean, mean + DEVIATIONS * (double)s->work.pass_time[SPREAD]);
    if (left < 0) return 0;
    return left >= each * (double)(s->n_stages + BESIDE) ? s->n_stages
                                                         : (integer)(left / each) - BESIDE;
}

/* Remember how long a pass took. */
static void note_pass(const Window *s, integer made, double began)
{
    if (!is_timed(s)) return;
    const real took = (real)((now(s) - began) / (double)(made + BESIDE));
    real *mean = s->work.pass_time + MEAN, *most = s->work.pass_time + MOST;
    real *deviation = s->work.pass_time + SPREAD;
    if (!(*mean > 0)) {
        *mean = took;
        return;
    }
    const real allowed = LARGEST * (*most > 1 ? *most : 1);
    const real away = fmin(took, allowed * *mean) - *mean;
    *most = took > allowed * *mean ? allowed : 1;
    *deviation += (real)NEWEST_SHARE * (fabs(away) - *deviation);
    *mean += (real)NEWEST_SHARE * away;
}

/* A step without a pass: the next may find the processor faster. */
static void note_none(const Window *s)
{
    s->work.pass_time[MEAN] *= (real)HOPE;
    s->work.pass_time[SPREAD] *= (real)HOPE;
}
