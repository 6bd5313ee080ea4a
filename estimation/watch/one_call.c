/* A step of a compiled estimator and its statistics in one call. Behind clean.c; the structures
 * Kept (blocks of what is kept beside the estimator's own state) and Stepping are declared in front. */
#include <stdint.h>

typedef void (*step_function)(void *self, const real *given, real *memory, real time,
                              const real *y, real *result);

/* Take an instant that is not late; behind what a step told, and its result, is what the watch keeps.
 * Returns whether nothing stands out, as `watch_one` has it; the estimator's state and result are
 * made in any case. */
integer watch_step(const Stepping *w, const real *given, real *memory, real time_s, const real *y,
                   const real *told, real *result);
integer watch_step(const Stepping *w, const real *given, real *memory, real time_s, const real *y,
                   const real *told, real *result)
{
    const Kept *at = &w->kept;
    const real *before = told + w->result_size, *calmer = before + at->calmer;
    real *after = result + w->result_size;
    ((step_function)w->step)((void *)(intptr_t)w->self, given, memory, time_s, y, result);
    const integer status = (integer)result[w->status];
    if (status & STATUS_SOLVER_FAILED) return 0; /* another solver may have to try */
    result[w->status] = (real)(status | w->remark);
    memcpy(after + at->known, before + at->known, (size_t)(at->size - at->known) * sizeof(real));
    return watch_one(&w->statistics, before + at->memory, after + at->memory, time_s, y,
                     result + w->innovation, result + w->innovation_covariance, w->n_x,
                     result + w->covariance, w->limit, before + at->known, before + at->std,
                     after + at->std, calmer[0], calmer[1], calmer[2]);
}
