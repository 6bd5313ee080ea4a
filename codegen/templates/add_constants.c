/* What sensors read that read a constant, at the first measurement of each of their periods. */
static void add_constants(@{prefix}_state *state, double time_s, real *y)
{
    const double largest = time_s > -state->first_s ? time_s : -state->first_s;
    const double spacing = 2 * (nextafter(largest, HUGE_VAL) - largest);
    const double since = time_s - state->first_s + (spacing > @tick ? spacing : @tick);
    for (size_t i = 0; i < sizeof constants / sizeof *constants; i++) {
        if (constants[i].rate_hz > 0) {
            const double periods = since * constants[i].rate_hz; /* whole where it is no long long */
            const double period = periods < 0x1p53 ? (double)(long long)periods : periods;
            if (!(period > state->period[i])) continue;
            state->period[i] = period;
        }
        for (integer j = 0; j < constants[i].n; j++)
            y[constants[i].column + j] = constants[i].value[j];
    }
}
