
/* The public functions of @prefix.h. */

/* Not for the compiler to see through: it would warn of arrays that a model has no use for. */
static void *volatile own = (void *)&self;

static const struct { integer at; real value; } start[] = @start;@watch_start
static const integer measured[] = @measured;
@constants
void @{prefix}_init(@{prefix}_state *state)
{
    memset(state, 0, sizeof *state);
    for (size_t i = 0; i < sizeof start / sizeof *start; i++)
        state->memory[0][start[i].at] = start[i].value;
    for (size_t i = 0; i < sizeof state->period / sizeof *state->period; i++) state->period[i] = -1;@init_watch
}

@add_constants@rebase
int @{prefix}_step(@{prefix}_state *state, double time_s, const @{prefix}_real readings[@{PREFIX}_N_Y],
        @{prefix}_estimate *estimate)
{
    if (!isfinite(time_s)) return -1;
    @check_inputs
    if (!state->started) state->first_s = state->origin_s = state->newest_s = time_s;
    state->started = 1;
    const int late = time_s < state->newest_s;
    const real time = @time;
    real y[@n_y];
    for (integer i = 0; i < @n_y; i++) y[i] = NAN;
    for (integer i = 0; i < @{PREFIX}_N_Y; i++) y[measured[i]] = readings[i];
    @call_constants
    real *memory = state->memory[!state->at];
    real *told = (real *)((char *)estimate + offsetof(@{prefix}_estimate, @first));
    @step
    if (!late) state->newest_s = time_s;
    state->at = !state->at;
    estimate->time_s = state->newest_s;
@numbers
    @call_rebase
    return 0;
}
