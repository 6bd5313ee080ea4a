/* Calls of generated functions, and arithmetic on arrays. Behind estimation/sizes.c. */

/* Call a generated function. Its pointers are room that it may use: all come from the model. */
static inline void call(const Model *m, const Function *f, const real *const *arguments,
                        real *const *results)
{
    for (integer i = 0; i < f->n_arguments; i++) m->arguments[i] = arguments[i];
    for (integer i = 0; i < f->n_results; i++) m->results[i] = results[i];
    m->arguments[f->n_arguments] = f->constants;
    f->evaluate(m->arguments, m->results, m->integers, m->reals, 0);
}

static inline void copy(real *to, const real *from, integer n)
{
    memcpy(to, from, (size_t)n * sizeof(real));
}

static inline real dot(const real *a, const real *b, integer n)
{
    real sums[4] = {0, 0, 0, 0};
    integer i = 0;
    for (; i + 4 <= n; i += 4)
        for (integer j = 0; j < 4; j++) sums[j] += a[i + j] * b[i + j];
    for (; i < n; i++) sums[0] += a[i] * b[i];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}
