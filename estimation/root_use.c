/* What loops ask of a root S, P = S S', lower triangular. Behind estimation/sizes.c. */

/* P v = S (S' v). */
static inline void spread_root(const Model *m, const real *S, const real *v, real *product)
{
    const integer n = N_X;
    (void)m;
    memset(product, 0, (size_t)n * sizeof(real));
    for (integer i = 0; i < n; i++) /* a bound's row has one entry */
        for (integer j = 0; v[i] != 0 && j <= i; j++) product[j] += S[i * LD + j] * v[i];
    for (integer i = n - 1; i >= 0; i--) product[i] = dot(S + i * LD, product, i + 1);
}

/* D S in place: the standard deviation of each state times `by`. */
static inline void stretch_root(const Model *m, real *S, const real *by)
{
    const integer n = N_X;
    (void)m;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++) S[i * LD + j] *= by[i];
}

static inline real variance_root(const Model *m, const real *S, integer i)
{
    (void)m;
    return dot(S + i * LD, S + i * LD, i + 1);
}

static inline void covariance_of_root(const Model *m, const real *S, real *covariance)
{
    const integer n = N_X;
    (void)m;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++) {
            covariance[i * n + j] = dot(S + i * LD, S + j * LD, j + 1);
            covariance[j * n + i] = covariance[i * n + j];
        }
}
