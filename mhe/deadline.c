/* A step that must be answered in time. Behind mhe/active_set.c.
 *
 * Before every pass the clock is asked whether one more would end in time, going by how long
 * passes took of late: their running mean per stage, and half as much again for safety. A
 * single longer one (the processor was elsewhere) counts as twice the mean, the next in a row
 * as four times, and so on. */

#define NEWEST_SHARE 0.1
#define LARGEST 2
#define SAFETY 1.5
#define HOPE 0.95

static double now(const Window *s)
{
    return s->clock ? ((double (*)(void))(void (*)(void))s->clock)() : seconds();
}

/* Whether a pass over so many stages would end behind the deadline. */
static int is_late(const Window *s, integer count, double start)
{
    if (!isfinite(s->deadline)) return 0;
    const double expected = SAFETY * (double)s->work.pass_time[0] * (double)count;
    return now(s) - start + expected > (double)s->deadline;
}

/* Remember how long a pass took. */
static void note_pass(const Window *s, integer count, double began)
{
    if (!isfinite(s->deadline)) return;
    const real took = (real)((now(s) - began) / (double)count);
    real *mean = s->work.pass_time, *most = s->work.pass_time + 1;
    const real allowed = LARGEST * (*most > 1 ? *most : 1);
    const real counted = fmin(took, allowed * *mean);
    *most = took > allowed * *mean ? allowed : 1;
    *mean = *mean > 0 ? *mean + (real)NEWEST_SHARE * (counted - *mean) : took;
}

/* A step without a pass: the next may find the processor faster. */
static void note_none(const Window *s) { s->work.pass_time[0] *= (real)HOPE; }
