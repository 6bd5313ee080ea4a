/* The Kalman stage in covariances, compiled for models of one size: N_X, N_W and N_R are constants.
 * Behind estimation/covariance_form.c, whose square roots take over where P - W W' would lose digits.
 *
 * All algebra is sums of rows, which run through memory in quads; rows of readings that are not there
 * are not touched. What P loses is bounded as it goes: a row whose innovation has LOST times the
 * variance of its noise, or a state whose variance a prediction makes LOST times as large, leaves P
 * with as many digits fewer. Such a stage is made in square roots, and its result kept as one until P
 * can hold it again. */

#define QUADS (LD / QUAD)

/* to = the sum of `count` rows, each by its factor, on top of `start` where there is one. */
static inline __attribute__((always_inline)) void sum_rows(real *to, const real *start,
                                                           const real *rows, const integer *which,
                                                           const real *factor, integer count)
{
    quad sum[QUADS];
    for (integer q = 0; q < QUADS; q++) sum[q] = start ? AT(start + q * QUAD) : ALL(0);
    for (integer k = 0; k < count; k++) {
        const real *row = rows + which[k] * LD;
        for (integer q = 0; q < QUADS; q++) sum[q] += ALL(factor[k]) * AT(row + q * QUAD);
    }
    for (integer q = 0; q < QUADS; q++) PUT(to + q * QUAD, sum[q]);
}

/* F of some rows, which is sums of them, on top of `more` where there is such. Rows behind the last
 * state are zero. */
static inline void product(const Model *m, const real *F, const real *rows, const real *more,
                           real *restrict to)
{
    for (integer i = 0; i < N_X; i++) {
        const integer first = m->F_at[i], count = m->F_at[i + 1] - first;
        const quad own = ALL(m->F_unit[i]);
        quad sum[QUADS];
        for (integer q = 0; q < QUADS; q++) {
            sum[q] = own * AT(rows + i * LD + q * QUAD);
            if (more) sum[q] += AT(more + i * LD + q * QUAD);
        }
        for (integer k = first; k < first + count; k++) {
            const real *row = rows + m->F_column[k] * LD;
            for (integer q = 0; q < QUADS; q++) sum[q] += ALL(F[k]) * AT(row + q * QUAD);
        }
        for (integer q = 0; q < QUADS; q++) PUT(to + i * LD + q * QUAD, sum[q]);
    }
    for (integer i = N_X; i < LD; i++)
        for (integer q = 0; q < QUADS; q++) PUT(to + i * LD + q * QUAD, ALL(0));
}

/* P- = F P+ F' + Q. Returns whether it has its digits. */
static int predict_covariance(const Model *m, const real *F, const real *P_plus,
                              real *restrict P_minus)
{
    real *half = m->array, *turned = m->array + LD * LD;
    int kept = 1;
    for (integer k = 0; k < m->nnz_Q; k++) { /* all others stay zero */
        m->Q[m->Q_low[k]] = m->Q_entries[k];
        m->Q[m->Q_high[k]] = m->Q_entries[k];
    }
    product(m, F, P_plus, 0, half);
    for (integer i = 0; i < LD; i += QUAD)
        for (integer j = 0; j < LD; j += QUAD) {
            quad block[QUAD];
            for (integer a = 0; a < QUAD; a++) block[a] = AT(half + (i + a) * LD + j);
            turn(block, turned + j * LD + i, LD);
        }
    product(m, F, turned, m->Q, P_minus);
    for (integer i = 0; i < N_X; i++)
        if (P_minus[i * (LD + 1)] > LOST * P_plus[i * (LD + 1)]) kept = 0;
    return kept;
}

/* P - W W', by blocks of the lower triangle, and the upper one like it. */
static void take_rows(const real *restrict P, const real *restrict W, const integer *rows,
                      integer count, real *restrict left)
{
    for (integer i = 0; i < LD; i += QUAD)
        for (integer j = 0; j <= i; j += QUAD) {
            quad block[QUAD];
            for (integer a = 0; a < QUAD; a++) block[a] = AT(P + (i + a) * LD + j);
            for (integer k = 0; k < count; k++) {
                const real *w = W + rows[k] * LD;
                for (integer a = 0; a < QUAD; a++) block[a] -= ALL(w[i + a]) * AT(w + j);
            }
            turn(block, left + j * LD + i, LD);
            if (j < i)
                for (integer a = 0; a < QUAD; a++) PUT(left + (i + a) * LD + j, block[a]);
        }
    for (integer i = 0; i < LD; i++) /* blocks on the diagonal: the lower triangle counts */
        for (integer j = i / QUAD * QUAD; j < i; j++) left[i * LD + j] = left[j * LD + i];
}

/* P+ = P- - W W', with L and W of the rows present and d_plus, whitened innovations in e. Returns
 * whether it has its digits. */
static int update_covariance(const Model *m, const real *H, const real *v, const real *present,
                             const real *P_minus, real *d_plus, real *P_plus, real *W, real *e,
                             real *L)
{
    integer *rows = m->rows, count = 0;
    real *factor = m->factor, moved[LD];
    int kept = 1, finite = 1;
    for (integer r = 0; r < N_R; r++) {
        e[r] = 0;
        if (present[r] != 0) rows[count++] = r;
    }
    for (integer a = 0; a < count && a < N_R; a++) { /* row by row: L L' = S and W' = L^-1 H P- */
        const integer r = rows[a], first = m->H_at[r], end = m->H_at[r + 1];
        const real noise = m->noise_std[r] * m->noise_std[r];
        real *w = W + r * LD, *own = ROW(L, r), square = noise, whitened = v[r];
        sum_rows(w, 0, P_minus, m->H_column + first, H + first, end - first);
        for (integer k = first; k < end; k++) square += H[k] * w[m->H_column[k]];
        for (integer b = 0; b < a; b++) { /* (L^-1 H P-) H' is a row of L */
            const real *before = W + rows[b] * LD;
            real entry = 0;
            for (integer k = first; k < end; k++) entry += H[k] * before[m->H_column[k]];
            own[rows[b]] = entry;
            factor[b] = -entry;
            square -= entry * entry;
            whitened -= entry * e[rows[b]];
        }
        if (!isfinite(square)) finite = 0; /* an absurd reading: no root mends it */
        if (finite && !(square > 0 && square <= LOST * noise)) kept = 0;
        const real length = sqrt(square), by = 1 / length;
        sum_rows(w, w, W, rows, factor, a);
        for (integer q = 0; q < QUADS; q++) PUT(w + q * QUAD, AT(w + q * QUAD) * ALL(by));
        own[r] = length;
        e[r] = whitened * by;
    }
    if (d_plus) {
        for (integer i = 0; i < LD; i++) moved[i] = i < N_X ? d_plus[i] : 0;
        for (integer a = 0; a < count; a++) factor[a] = e[rows[a]];
        sum_rows(moved, moved, W, rows, factor, count);
        copy(d_plus, moved, N_X);
    }
    if (!P_plus) return kept;
    take_rows(P_minus, W, rows, count, P_plus);
    for (integer i = 0; i < N_X; i++)
        if (P_plus[i * (LD + 1)] < 0) kept = 0;
    return kept;
}

/* The root of what an array named P_ holds. A variance that rounding has left below zero is none. */
static const real *root_of(const Model *m, const real *P)
{
    const integer n = N_X;
    real *S = m->root;
    if (is_root(P)) return P;
    memset(S, 0, (size_t)P_SIZE * sizeof(real));
    for (integer j = 0; j < n; j++) {
        const real left = P[j * (LD + 1)] - dot(S + j * LD, S + j * LD, j);
        S[j * (LD + 1)] = left > 0 ? sqrt(left) : 0;
        for (integer i = j + 1; left > 0 && i < n; i++)
            S[i * LD + j] = (P[i * LD + j] - dot(S + i * LD, S + j * LD, j)) / S[j * (LD + 1)];
    }
    return S;
}

static void predict(const Model *m, const real *d_plus, const real *P_plus, const real *x_lin,
                    const real *w_lin, const real *dt, const real *noise_scale,
                    const real *const *u, real *const *results)
{
    real *P_minus = results[2];
    real *F = results[3] ? results[3] : m->F, *G = results[4] ? results[4] : m->G;
    step_at(m, d_plus, x_lin, w_lin, dt, noise_scale, u, results[0], results[1], F, G,
            P_minus ? m->Q_entries : 0);
    if (!P_minus) return;
    if (!is_root(P_plus) && predict_covariance(m, F, P_plus, P_minus)) return;
    predict_root(m, F, G, root_of(m, P_plus), noise_scale, m->root);
    keep_root(m, m->root, P_minus);
}

static void update(const Model *m, const real *d_minus, const real *P_minus, const real *x_lin,
                   const real *y, const real *present, real *const *results)
{
    real *d_plus = results[0], *P_plus = results[1];
    real *v = results[2] ? results[2] : m->v, *W = results[4] ? results[4] : m->W;
    real *e = results[5] ? results[5] : m->e, *H = results[6] ? results[6] : m->H;
    real *L = results[7] ? results[7] : m->L;
    read_at(m, d_minus, x_lin, y, present, v, H);
    if (d_plus) copy(d_plus, d_minus, N_X);
    if (is_root(P_minus)
        || !update_covariance(m, H, v, present, P_minus, d_plus, P_plus, W, e, L)) {
        if (d_plus) copy(d_plus, d_minus, N_X);
        update_root(m, H, v, root_of(m, P_minus), present, d_plus, P_plus ? m->root : 0, W, e, L);
        if (P_plus) keep_root(m, m->root, P_plus);
    }
    if (results[3]) innovation_covariance(m, present, L, results[3]);
}

