/* The Kalman stage in covariances: an array named P_ holds P, n_x by n_x. Behind
 * estimation/engine.c. */

/* δ⁻ around f(x̃, w̃) in `reached`, P⁻, F, G; a result that is not wanted is 0. */
static void predict(const Model *m, const real *d_plus, const real *P_plus,
                    const real *x_lin, const real *w_lin, const real *dt,
                    const real *noise_scale, real *results[5])
{
    const real *arguments[] = {d_plus, P_plus, x_lin, w_lin, dt, noise_scale};
    m->predict(arguments, results, 0, 0, 0);
}

/* δ⁺, P⁺, v, S, W, e, H, L. */
static void update(const Model *m, const real *d_minus, const real *P_minus,
                   const real *x_lin, const real *y, const real *present,
                   real *results[8])
{
    const real *arguments[] = {d_minus, P_minus, x_lin, y, present};
    m->update(arguments, results, 0, 0, 0);
}

/* P v, column by column: a bound's row has one entry. */
static inline void spread(const Model *m, const real *restrict P, const real *restrict v,
                          real *restrict product)
{
    const integer n = m->n_x;
    memset(product, 0, (size_t)n * sizeof(real));
    for (integer j = 0; j < n; j++) {
        const real factor = v[j], *restrict column = P + j * n;
        if (factor == 0) continue;
        for (integer i = 0; i < n; i++) product[i] += column[i] * factor;
    }
}

/* P - W W' in place. */
static inline void take_from(const Model *m, real *P, const real *W)
{
    for (integer i = 0; i < m->n_x; i++)
        for (integer j = 0; j < m->n_x; j++) P[i * m->n_x + j] -= W[i] * W[j];
}

/* Variance of one state. */
static inline real variance(const Model *m, const real *P, integer i) { return P[i * (m->n_x + 1)]; }

static void covariance_of(const Model *m, const real *P, real *covariance)
{
    copy(covariance, P, m->n_x * m->n_x);
}
