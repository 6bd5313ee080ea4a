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

/* The covariances (n, LD * LD) behind n rows of readings, linearised along known states x (n, n_x): P is
 * in front of the first. Rows y (n, n_row) have no gaps and end with the inputs; dt (n,) leads to each. */
void kernel_sweep(const Model *m, integer n, const real *P, const real *x, const real *dt, const real *y,
                  const real *present, const real *zeros, const real *ones, real *covariances)
{
    real reached[N_X], deviation[N_X], P_minus[LD * LD];
    real *predicted[] = {reached, deviation, P_minus, 0, 0};
    for (integer k = 0; k < n; k++) {
        const real *row = y + k * m->n_row, *known = P;
        real *P_plus = covariances + k * m->n_P, *updated[] = {deviation, P_plus, 0, 0, 0, 0, 0, 0};
        if (k > 0) {
            const real *u[] = {row - m->n_row + m->n_y, row + m->n_y};
            predict(m, zeros, P_plus - m->n_P, x + (k - 1) * N_X, zeros, dt + k, ones, u, predicted);
            known = P_minus;
        }
        update(m, zeros, known, x + k * N_X, row, present + k * m->n_r, updated);
    }
}
