/* What loops ask of an array named P_. Behind estimation/covariance_form.c and estimation/root_use.c. */

/* A reading of C' delta without noise, in place: S loses a direction, and no sign of its diagonal. */
static inline void take_from_root(const Model *m, real *S, const real *C)
{
    const integer n = N_X;
    real *own = m->along, *u = m->factor, length = 0;
    memset(own, 0, (size_t)n * sizeof(real));
    memset(u, 0, (size_t)n * sizeof(real));
    for (integer i = 0; i < n; i++)
        for (integer j = 0; C[i] != 0 && j <= i; j++) u[j] += S[i * LD + j] * C[i];
    for (integer c = n - 1; c >= 0; c--) {
        if (u[c] == 0) continue;
        const real both = sqrt(length * length + u[c] * u[c]);
        const real cosine = length / both, sine = u[c] / both;
        for (integer i = c; i < n; i++) {
            const real turned = cosine * own[i] + sine * S[i * LD + c];
            S[i * LD + c] = cosine * S[i * LD + c] - sine * own[i];
            own[i] = turned;
        }
        length = both;
    }
    if (S[0] == 0) S[0] = -(real)0;
}

/* P v, column by column: a bound's row has one entry. */
static inline void spread(const Model *m, const real *restrict P, const real *restrict v,
                          real *restrict product)
{
    const integer n = N_X;
    if (is_root(P)) {
        spread_root(m, P, v, product);
        return;
    }
    memset(product, 0, (size_t)n * sizeof(real));
    for (integer j = 0; j < n; j++) {
        const real by = v[j], *restrict column = P + j * LD;
        if (by == 0) continue;
        for (integer i = 0; i < n; i++) product[i] += column[i] * by;
    }
}

/* P - W W' in place, where W = P C / sqrt(C' P C): a reading without noise of C' delta. */
static inline void take_from(const Model *m, real *P, const real *C, const real *W)
{
    const integer n = N_X;
    if (is_root(P)) {
        take_from_root(m, P, C);
        return;
    }
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j < n; j++) P[i * LD + j] -= W[i] * W[j];
    for (integer i = 0; i < n; i++) /* what rounding leaves below zero is none, and no mark of a root */
        if (P[i * (LD + 1)] < 0) P[i * (LD + 1)] = 0;
}

/* P + by Q in place; Q (LD, LD) is a covariance. */
static inline void add_covariance(const Model *m, real *P, real by, const real *Q)
{
    if (is_root(P)) {
        add_to_root(m, P, by, Q, m->root);
        keep_root(m, m->root, P);
        return;
    }
    for (integer i = 0; i < N_X; i++)
        for (integer j = 0; j < N_X; j++) P[i * LD + j] += by * Q[i * LD + j];
}

/* Variance of one state. */
static inline real variance(const Model *m, const real *P, integer i)
{
    return is_root(P) ? variance_root(m, P, i) : P[i * (LD + 1)];
}

static void covariance_of(const Model *m, const real *P, real *covariance)
{
    if (is_root(P))
        covariance_of_root(m, P, covariance);
    else
        for (integer i = 0; i < N_X; i++) copy(covariance + i * N_X, P + i * LD, N_X);
}
