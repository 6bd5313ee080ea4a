/* Times of the loop are relative to an origin that follows them, or a float could not tell two
 * samples apart for long. Where the newest is not twice as far from it as the oldest, their
 * differences are exact, and so is the shift. */
static void rebase(@{prefix}_state *state, real *memory, real newest)
{
    const real oldest = memory[@first];
    if (!(oldest > 0) || newest - oldest > oldest) return;
@shifts
    state->origin_s += (double)oldest;
}

/* A time that is that of an instant of the loop but for rounding: another origin was its own. */
static real snapped(const real *memory, real time, real newest)
{
    const real *times = memory + @first, tick = @tick * newest;
    for (integer i = 0; i < @n_times; i++)
        if (times[i] - time <= tick && time - times[i] <= tick) return times[i];
    return time;
}
