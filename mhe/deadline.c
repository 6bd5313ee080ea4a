/* A step that must be answered in time. Behind mhe/active_set.c.
 *
 * Before every pass the clock is asked whether one more would end in time, going by how long
 * passes took of late: their running mean per stage whose factors are made, and half as much again
 * for safety. A single longer one (the processor was elsewhere) counts as twice the mean, the next
 * in a row as four times, and so on. */

#define NEWEST_SHARE 0.1
#define LARGEST 2
#define SAFETY 1.5
#define HOPE 0.95
#define BESIDE 2 /* stages: what a pass takes beside its factors */

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
    const double each = SAFETY * (double)s->work.pass_time[0];
    if (left < 0) return 0;
    return left >= each * (double)(s->n_stages + BESIDE) ? s->n_stages
                                                         : (integer)(left / each) - BESIDE;
}

/* Remember how long a pass took. */
static void note_pass(const Window *s, integer made, double began)
{
    if (!is_timed(s)) return;
    const real took = (real)((now(s) - began) / (double)(made + BESIDE));
    real *mean = s->work.pass_time, *most = s->work.pass_time + 1;
    const real allowed = LARGEST * (*most > 1 ? *most : 1);
    const real counted = fmin(took, allowed * *mean);
    *most = took > allowed * *mean ? allowed : 1;
    *mean = *mean > 0 ? *mean + (real)NEWEST_SHARE * (counted - *mean) : took;
}

/* A step without a pass: the next may find the processor faster. */
static void note_none(const Window *s) { s->work.pass_time[0] *= (real)HOPE; }
