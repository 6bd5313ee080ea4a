/* Covariances, and what an array named P_ holds of one: P, symmetric, or the mark and a root of it.
 * Behind estimation/reflections.c.
 *
 * A root S, P = S S', lower triangular, stands for P where that would have lost too many digits. No
 * entry of its diagonal is positive: the sign of the array's first number tells. */

static inline int is_root(const real *P) { return signbit(P[0]) != 0; }

/* A root's covariance, where that has its digits, else the root itself with its mark. */
static inline void keep_root(const Model *m, const real *S, real *P)
{
    const integer n = N_X;
    int fits = 1;
    (void)m;
    memset(P, 0, (size_t)P_SIZE * sizeof(real));
    for (integer i = 0; i < n; i++)
        if (!(LOST * S[i * (LD + 1)] * S[i * (LD + 1)] >= dot(S + i * LD, S + i * LD, i + 1)))
            fits = 0;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; fits && j <= i; j++) {
            P[i * LD + j] = dot(S + i * LD, S + j * LD, j + 1);
            P[j * LD + i] = P[i * LD + j];
        }
    for (integer i = 0; !fits && i < n; i++)
        for (integer j = 0; j <= i; j++)
            P[i * LD + j] = S[j * (LD + 1)] > 0 ? -S[i * LD + j] : S[i * LD + j];
    if (!fits && P[0] == 0) P[0] = -(real)0;
}
