/* A stage as a library of its own. Behind estimation/covariance_stage.c. */

void kernel_predict(const Model *m, const real *d_plus, const real *P_plus, const real *x_lin,
                    const real *w_lin, const real *dt, const real *noise_scale,
                    const real *const *u, real *const *results)
{
    predict(m, d_plus, P_plus, x_lin, w_lin, dt, noise_scale, u, results);
}

void kernel_update(const Model *m, const real *d_minus, const real *P_minus, const real *x_lin,
                   const real *y, const real *present, real *const *results)
{
    update(m, d_minus, P_minus, x_lin, y, present, results);
}
