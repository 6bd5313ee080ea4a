/* The Kalman stage in square roots: an array named P_ holds S, P = S S', lower triangular, row by
 * row, its diagonal not negative. Behind estimation/engine.c.
 *
 *     predict:  [F S+, G D] Q = [S-, 0]
 *     update:   [R^1/2, H S-]     [L, 0 ]
 *               [0,       S-] Q = [W, S+],    e = L^-1 v,   delta+ = delta- + W e
 *
 * with Q orthogonal. Multiplied by its transpose, each line is the covariance form's; no step
 * subtracts one covariance from another, so S S' is one in any arithmetic. The arrays are kept
 * column by column: all inner loops run through memory in order. */

/* Turn the columns from `row` on of an array so that this row's tail becomes zero and its head, on
 * the diagonal, a length; rows below turn along. Householder's reflection with its first column's
 * sign turned round: no branch on the sign, and nothing cancels. */
static void reflect(const Model *m, integer n_rows, integer width, integer row)
{
    real *restrict head = m->array + row * n_rows, *restrict along = m->along;
    const integer below = row + 1;
    real square = head[row] * head[row];
    for (integer j = below; j < n_rows; j++) along[j] = head[j] * head[row];
    for (integer c = row + 1; c < width; c++) {
        const real *restrict column = m->array + c * n_rows, u = column[row];
        if (u == 0) continue; /* most of the pattern */
        square += u * u;
        for (integer j = below; j < n_rows; j++) along[j] += column[j] * u;
    }
    const real length = sqrt(square), sign = copysign(1, head[row]);
    const real both = length + fabs(head[row]);
    if (length == 0) return;
    for (integer j = below; j < n_rows; j++) {
        const real turned = along[j] / length;
        along[j] = (turned + sign * head[j]) / both;
        head[j] = turned;
    }
    for (integer c = row + 1; c < width; c++) {
        real *restrict column = m->array + c * n_rows, u = column[row];
        if (u == 0) continue;
        for (integer j = below; j < n_rows; j++) column[j] -= along[j] * u;
    }
    head[row] = length;
}

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
 * leaves S triangular and its diagonal positive. Each state keeps as many digits of what it
 * is known by afterwards as of what it was known by before (Carlson 1973). */
static void absorb_row(const Model *m, integer row)
{
    const integer n_r = m->n_r, n = n_r + m->n_x;
    real *own = m->array + row * n;
    for (integer c = m->n_x - 1; c >= 0; c--) {
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

/* δ⁻ around f(x̃, w̃) in `reached`, S⁻, F, G; a result that is not wanted is 0. */
static void predict(const Model *m, const real *d_plus, const real *S_plus, const real *x_lin,
                    const real *w_lin, const real *dt, const real *noise_scale, real *results[5])
{
    const integer n_x = m->n_x, width = n_x + m->n_w;
    real *d_minus = results[1], *S_minus = results[2], *array = m->array;
    real *F = results[3] ? results[3] : m->F, *G = results[4] ? results[4] : m->G;
    const real *arguments[] = {x_lin, w_lin, dt};
    real *linear[] = {results[0], F, G};
    m->predict(arguments, linear, 0, 0, 0);
    if (d_minus) memset(d_minus, 0, (size_t)n_x * sizeof(real));
    memset(array, 0, (size_t)(n_x * width) * sizeof(real));
    for (integer k = 0; k < m->nnz_F; k++) {
        const integer i = m->F_row[k], j = m->F_column[k];
        const real *S = S_plus + j * n_x;
        if (d_minus) d_minus[i] += F[k] * d_plus[j];
        for (integer c = 0; c <= j; c++) array[c * n_x + i] += F[k] * S[c];
    }
    for (integer k = 0; k < m->nnz_G; k++) {
        const integer i = m->G_row[k], j = m->G_column[k];
        if (d_minus) d_minus[i] -= G[k] * w_lin[j];
        array[(n_x + j) * n_x + i] = G[k] * noise_scale[j];
    }
    for (integer i = 0; S_minus && i < n_x; i++) reflect(m, n_x, width, i);
    for (integer i = 0; S_minus && i < n_x; i++)
        for (integer j = 0; j < n_x; j++) S_minus[i * n_x + j] = j > i ? 0 : array[j * n_x + i];
}

/* δ⁺, S⁺, v, the innovations' covariance, W, e, H, L; a result that is not wanted is 0. */
static void update(const Model *m, const real *d_minus, const real *S_minus, const real *x_lin,
                   const real *y, const real *present, real *results[8])
{
    const integer n_x = m->n_x, n_r = m->n_r, n = n_r + n_x;
    real *d_plus = results[0], *S_plus = results[1], *S = results[3], *W = results[4];
    real *v = results[2] ? results[2] : m->v, *e = results[5] ? results[5] : m->e;
    real *H = results[6] ? results[6] : m->H, *L = results[7], *array = m->array;
    const real *arguments[] = {x_lin, y};
    real *linear[] = {v, H};
    m->update(arguments, linear, 0, 0, 0);
    memset(array, 0, (size_t)(n * n) * sizeof(real));
    for (integer i = 0; i < n_r; i++) {
        array[i * n + i] = m->noise_std[i];
        v[i] *= present[i];
    }
    for (integer k = 0; k < m->nnz_H; k++) {
        const integer i = m->H_row[k], j = m->H_column[k];
        H[k] *= present[i];
        v[i] -= H[k] * d_minus[j];
        for (integer c = 0; c <= j; c++) array[(n_r + c) * n + i] += H[k] * S_minus[j * n_x + c];
    }
    for (integer i = 0; i < n_x; i++)
        for (integer c = 0; c <= i; c++) array[(n_r + c) * n + n_r + i] = S_minus[i * n_x + c];
    for (integer i = 0; i < n_r; i++) absorb_row(m, i);

    copy(e, v, n_r);
    if (d_plus) copy(d_plus, d_minus, n_x);
    for (integer j = 0; j < n_r; j++) {
        const real *column = array + j * n;
        e[j] /= column[j];
        for (integer i = j + 1; i < n_r; i++) e[i] -= column[i] * e[j];
        for (integer i = 0; d_plus && i < n_x; i++) d_plus[i] += column[n_r + i] * e[j];
        if (W) copy(W + j * n_x, column + n_r, n_x);
    }
    for (integer k = 0; L && k < m->nnz_L; k++) L[k] = array[m->L_column[k] * n + m->L_row[k]];
    if (S) memset(S, 0, (size_t)(n_r * n_r) * sizeof(real));
    for (integer k = 0; S && k < n_r; k++)
        for (integer i = k; i < n_r; i++)
            for (integer j = k; j < n_r; j++)
                S[i * n_r + j] += array[k * n + i] * array[k * n + j];
    for (integer i = 0; S_plus && i < n_x; i++)
        for (integer j = 0; j < n_x; j++)
            S_plus[i * n_x + j] = j > i ? 0 : array[(n_r + j) * n + n_r + i];
}

/* P v = S (S' v). */
static inline void spread(const Model *m, const real *S, const real *v, real *product)
{
    const integer n = m->n_x;
    memset(product, 0, (size_t)n * sizeof(real));
    for (integer i = 0; i < n; i++) /* a bound's row has one entry */
        for (integer j = 0; v[i] != 0 && j <= i; j++) product[j] += S[i * n + j] * v[i];
    for (integer i = n - 1; i >= 0; i--) product[i] = dot(S + i * n, product, i + 1);
}

static inline real variance(const Model *m, const real *S, integer i)
{
    return dot(S + i * m->n_x, S + i * m->n_x, i + 1);
}

static void covariance_of(const Model *m, const real *S, real *covariance)
{
    const integer n = m->n_x;
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j <= i; j++)
            covariance[i * n + j] = covariance[j * n + i] = dot(S + i * n, S + j * n, j + 1);
}
