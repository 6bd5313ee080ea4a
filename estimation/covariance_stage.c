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

/* P v. */
static inline void spread(const Model *m, const real *P, const real *v, real *product)
{
    for (integer i = 0; i < m->n_x; i++) product[i] = dot(P + i * m->n_x, v, m->n_x);
}

/* Variance of one state. */
static inline real variance(const Model *m, const real *P, integer i) { return P[i * (m->n_x + 1)]; }
