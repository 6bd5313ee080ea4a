/* @title
 *
 * Written by pen-mhe codegen. C99, no dynamic memory. Times in s, everything else in SI and rad.
 * The estimator's workspace is static: one call at a time, from one thread. States are the caller's:
 * several may take turns. */
#ifndef @{PREFIX}_H
#define @{PREFIX}_H

#ifdef __cplusplus
extern "C" {
#endif

typedef @real @{prefix}_real;

@sizes

/* States, as in `mean` and in rows and columns of `covariance`. */
@states

@derived
@lags
/* Readings of a measurement; NaN where there is none. */
@readings

@rows

@constants

/* Remarks on a step; several may hold at once. */
@statuses
@flags
/* What a step tells. */
typedef struct {
@fields
} @{prefix}_estimate;

/* An estimator between two measurements; its members are private. */
typedef struct {
    double newest_s, origin_s, first_s, period[@n_constants];
    int started, at;
    @{prefix}_real memory[2][@n_memory];@watch_memory
} @{prefix}_state;

/* Begin: nothing is known but the prior. */
void @{prefix}_init(@{prefix}_state *state);

/* Take one measurement: all readings of one instant, in s. One that arrives when newer ones are
 * there is taken at its own time, and told is again the newest instant; where it is older than the
 * estimator can reach it changes nothing and is told as @{PREFIX}_STATUS_LATE. Returns 0, or -1 and nothing else where the time is not a finite number. */
int @{prefix}_step(@{prefix}_state *state, double time_s, const @{prefix}_real readings[@{PREFIX}_N_Y],
        @{prefix}_estimate *estimate);

#ifdef __cplusplus
}
#endif

#endif
