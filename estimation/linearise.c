/* A step and a set of readings, linearised: the generated functions, and where the filter's mean
 * goes by them. Sparse matrices come row by row (F, H) and column by column (G); ones on F's diagonal
 * that are always there are not among its numbers but in the table F_unit. Behind
 * estimation/arrays.c. */

/* f(x, w) in `reached`, F, G, the entries of Q, and d- = F d+ - G w; a result that is not wanted
 * is 0. `u`: the inputs at both ends of the step, which a model without inputs does not look at. */
static void step_at(const Model *m, const real *d_plus, const real *x_lin, const real *w_lin,
                    const real *dt, const real *noise_scale, const real *const *u, real *reached,
                    real *d_minus, real *F, real *G, real *Q)
{
    const real *arguments[] = {x_lin, w_lin, dt, noise_scale, u[0], u[1]};
    real *results[] = {reached, F, G, Q};
    call(m, &m->transition, arguments, results);
    if (!d_minus) return;
    for (integer i = 0; i < N_X; i++) {
        real sum = m->F_unit[i] * d_plus[i];
        for (integer k = m->F_at[i]; k < m->F_at[i + 1]; k++) sum += F[k] * d_plus[m->F_column[k]];
        d_minus[i] = sum;
    }
    for (integer w = 0; w < N_W; w++)
        for (integer k = m->G_at[w]; k < m->G_at[w + 1]; k++)
            d_minus[m->G_row[k]] -= G[k] * w_lin[w];
}

/* H, and v = residual - H d-, by the scales of the rows present; zero where these are. */
static void read_at(const Model *m, const real *d_minus, const real *x_lin, const real *y,
                    const real *present, real *v, real *H)
{
    const real *arguments[] = {x_lin, y};
    real *results[] = {v, H};
    call(m, &m->readings, arguments, results);
    for (integer r = 0; r < N_R; r++) {
        v[r] *= present[r];
        for (integer k = m->H_at[r]; k < m->H_at[r + 1]; k++) {
            H[k] *= present[r];
            v[r] -= H[k] * d_minus[m->H_column[k]];
        }
    }
}

/* S = L L', whose rows that are not present have their noise alone. */
static void innovation_covariance(const Model *m, const real *present, const real *L, real *S)
{
    memset(S, 0, (size_t)(N_R * N_R) * sizeof(real));
    for (integer i = 0; i < N_R; i++)
        for (integer j = 0; j <= i; j++) {
            real sum = i == j ? m->noise_std[i] * m->noise_std[i] : 0;
            if (present[i] != 0 && present[j] != 0) {
                sum = 0;
                for (integer k = 0; k <= j; k++)
                    if (present[k] != 0) sum += ROW(L, i)[k] * ROW(L, j)[k];
            }
            S[i * N_R + j] = sum;
            S[j * N_R + i] = sum;
        }
}
