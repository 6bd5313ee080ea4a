/* The Kalman stage in square roots: S, P = S S', lower triangular, row by row. Behind
 * estimation/reflections.c.
 *
 *     predict:  [F S+, G D] Q = [S-, 0]
 *     update:   [R^1/2, H S-]     [L, 0 ]
 *               [0,       S-] Q = [W, S+],    e = L^-1 v,   delta+ = delta- + W e
 *
 * with Q orthogonal. Multiplied by its transpose, each line is the covariance form's; no step
 * subtracts one covariance from another, so S S' is one in any arithmetic. The arrays are kept
 * column by column: all inner loops run through memory in order. */

/* Turn two columns by an angle, in some rows. */
static inline void rotate(real *restrict a, real *restrict b, integer from, integer to,
                          real cosine, real sine)
{
    for (integer j = from; j < to; j++) {
        const real turned = cosine * a[j] + sine * b[j];
        b[j] = cosine * b[j] - sine * a[j];
        a[j] = turned;
    }
}

/* Take one row of an update: turn its S' H' into the row's own column, from the last on, which
 * leaves S triangular and the signs of its diagonal. Each state keeps as many digits of what it
 * is known by afterwards as of what it was known by before (Carlson 1973). */
static void absorb_row(const Model *m, integer row)
{
    const integer n_r = N_R, n = n_r + N_X;
    real *own = m->array + row * n;
    for (integer c = N_X - 1; c >= 0; c--) {
        real *column = m->array + (n_r + c) * n;
        const real u = column[row];
        if (u == 0) continue;
        const real length = sqrt(own[row] * own[row] + u * u);
        const real cosine = own[row] / length, sine = u / length;
        rotate(own, column, row + 1, n_r, cosine, sine);
        rotate(own, column, n_r + c, n, cosine, sine);
        own[row] = length;
    }
}

/* S- of S+; they may be the same array. */
static void predict_root(const Model *m, const real *F, const real *G, const real *S_plus,
                         const real *noise_scale, real *S_minus)
{
    const integer n_x = N_X, width = n_x + N_W;
    real *array = m->array;
    memset(array, 0, (size_t)(n_x * width) * sizeof(real));
    for (integer i = 0; i < n_x; i++)
        for (integer c = 0; c <= i; c++) array[c * n_x + i] = m->F_unit[i] * S_plus[i * LD + c];
    for (integer i = 0; i < n_x; i++)
        for (integer k = m->F_at[i]; k < m->F_at[i + 1]; k++) {
            const integer j = m->F_column[k];
            for (integer c = 0; c <= j; c++) array[c * n_x + i] += F[k] * S_plus[j * LD + c];
        }
    for (integer w = 0; w < N_W; w++)
        for (integer k = m->G_at[w]; k < m->G_at[w + 1]; k++)
            array[(n_x + w) * n_x + m->G_row[k]] = G[k] * noise_scale[w];
    triangular(m, width, S_minus);
}

/* S+ of S- and of innovations v, W, L, whitened innovations e, and d+ from the d- that it holds;
 * S_plus, W and d_plus that are not wanted are 0, and S- and S+ may be the same array. Says in `lost`
 * where an innovation has so many times the variance of its noise that its digits are gone. */
static void update_root(const Model *m, const real *H, const real *v, const real *S_minus,
                        const real *present, real *d_plus, real *S_plus, real *W, real *e, real *L)
{
    const integer n_x = N_X, n_r = N_R, n = n_r + n_x;
    real *array = m->array;
    memset(array, 0, (size_t)(n * n) * sizeof(real));
    for (integer i = 0; i < n_r; i++) array[i * n + i] = m->noise_std[i];
    for (integer i = 0; i < n_r; i++)
        for (integer k = m->H_at[i]; k < m->H_at[i + 1]; k++) {
            const integer j = m->H_column[k];
            for (integer c = 0; c <= j; c++)
                array[(n_r + c) * n + i] += H[k] * S_minus[j * LD + c];
        }
    for (integer i = 0; i < n_x; i++)
        for (integer c = 0; c <= i; c++) array[(n_r + c) * n + n_r + i] = S_minus[i * LD + c];
    for (integer i = 0; i < n_r; i++)
        if (present[i] != 0) absorb_row(m, i);

    copy(e, v, n_r);
    for (integer j = 0; j < n_r; j++) {
        const real *column = array + j * n, known = column[j] / m->noise_std[j];
        if (known * known > BEYOND) *m->lost = 1;
        e[j] /= column[j];
        for (integer i = j + 1; i < n_r; i++) e[i] -= column[i] * e[j];
        for (integer i = 0; d_plus && i < n_x; i++) d_plus[i] += column[n_r + i] * e[j];
        if (W) {
            memset(W + j * LD, 0, (size_t)LD * sizeof(real));
            copy(W + j * LD, column + n_r, n_x);
        }
        for (integer i = j; i < n_r; i++) ROW(L, i)[j] = column[i];
    }
    for (integer i = 0; S_plus && i < n_x; i++)
        for (integer j = 0; j < LD; j++)
            S_plus[i * LD + j] = j > i ? 0 : array[(n_r + j) * n + n_r + i];
}
