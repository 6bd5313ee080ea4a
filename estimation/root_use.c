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

/* A root of S S' + by Q, lower triangular; Q (LD, LD) is a covariance, and the two may be the same
 * array. */
static inline void add_to_root(const Model *m, const real *S, real by, const real *Q, real *to)
{
    const integer n = N_X;
    real *sum = m->array;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++)
            sum[i * n + j] = dot(S + i * LD, S + j * LD, j + 1) + by * Q[i * LD + j];
    memset(to, 0, (size_t)P_SIZE * sizeof(real));
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++) {
            real left = sum[i * n + j] - dot(to + i * LD, to + j * LD, j);
            to[i * LD + j] = i == j ? sqrt(fmax(left, 0)) : left / to[j * (LD + 1)];
        }
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
