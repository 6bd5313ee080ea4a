/* Covariances of a window's earlier stages, given all its readings. Behind mhe/compiled/smoother.c;
 * mhe/look_back.py is the same in Python.
 *
 * A shift s of the filter's mean behind the readings of a stage comes back from those after it as a
 * costate Λ̂ s (modified Bryson-Frazier), so that the covariance given them all is
 *
 *     P_s = P⁺ - P⁺ Λ̂ P⁺,                                  Λ̂ = 0 at the newest stage,
 *     Λ = Mᵀ M + (I - W M)ᵀ Λ̂ (I - W M),   M = L⁻¹ H,      in front of a stage's readings,
 *     Λ̂ = Fᵀ Λ F                                           behind those of the stage before.
 *
 * One pass back serves all lags. With A = Wᵀ Λ̂ and X = A - (I + A W) M / 2 the second line is
 * Λ = Λ̂ - Mᵀ X - Xᵀ M. All matrices have rows of whole quads, zeros behind their numbers. */

/* A matrix as a factor: where it is, and how far its rows and its columns are apart. */
typedef struct {
    const real *at;
    integer row, column;
} Factor;

/* to += A B, a sum of `inner` terms from the first on; rows of `to` and B are `width` long. Four rows
 * at a time, so `rows` is a multiple of QUAD. */
static void add_product(real *restrict to, Factor A, const real *restrict B, integer rows,
                        integer inner, integer width)
{
    for (integer i = 0; i < rows; i += QUAD)
        for (integer c = 0; c < width; c += QUAD) {
            real *at = to + i * width + c;
            const real *a = A.at + i * A.row, *b = B + c;
            quad sum_0 = AT(at), sum_1 = AT(at + width);
            quad sum_2 = AT(at + 2 * width), sum_3 = AT(at + 3 * width);
            for (integer k = 0; k < inner; k++, a += A.column, b += width) {
                const quad row = AT(b);
                sum_0 += ALL(a[0]) * row;
                sum_1 += ALL(a[A.row]) * row;
                sum_2 += ALL(a[2 * A.row]) * row;
                sum_3 += ALL(a[3 * A.row]) * row;
            }
            PUT(at, sum_0);
            PUT(at + width, sum_1);
            PUT(at + 2 * width, sum_2);
            PUT(at + 3 * width, sum_3);
        }
}

/* y += a x of n numbers, whole quads. */
static inline void add_row(real *restrict y, real a, const real *restrict x, integer n)
{
    for (integer c = 0; c < n; c += QUAD) PUT(y + c, AT(y + c) + ALL(a) * AT(x + c));
}

/* The transpose of a square matrix of n rows, whole quads. */
static void transpose(const real *restrict from, real *restrict to, integer n)
{
    for (integer i = 0; i < n; i += QUAD)
        for (integer j = 0; j < n; j += QUAD) {
            const real *at = from + i * n + j;
            const quad block[QUAD] = {AT(at), AT(at + n), AT(at + 2 * n), AT(at + 3 * n)};
            turn(block, to + j * n + i, n);
        }
}

static inline void clear(real *to, integer n) { memset(to, 0, (size_t)n * sizeof(real)); }

/* Wᵀ, transposed, and M of those rows of stage k that are present, one behind the other. Returns how
 * many there are, in whole quads; rows behind the last one are zero. */
static integer whitened_rows(const Window *s, integer k, real *W_turned, real *M)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n = m->stride, n_r = m->n_r, most = (n_r + QUAD - 1) / QUAD * QUAD;
    const real *H = SLOT(o->H, k, s->nnz_H), *L = SLOT(o->L, k, s->nnz_L);
    const real *W = SLOT(o->W, k, n * n_r), *present = SLOT(o->at_rows, k, n_r);
    integer count = 0, *there = o->rows_there;
    clear(W_turned, n * most);
    clear(M, most * n);
    for (integer r = 0; r < n_r; r++)
        if (present[r] != 0) there[count++] = r;
    const integer rows = (count + QUAD - 1) / QUAD * QUAD;
    for (integer a = 0; a < count; a++) {
        const integer r = there[a];
        const real *own = ROW(L, r);
        real *row = M + a * n;
        for (integer i = 0; i < m->n_x; i++) W_turned[i * rows + a] = W[r * n + i];
        for (integer j = m->H_at[r]; j < m->H_at[r + 1]; j++) row[m->H_column[j]] = H[j];
        for (integer b = 0; b < a; b++) add_row(row, -own[there[b]], M + b * n, n);
        for (integer c = 0; c < n; c++) row[c] /= own[r];
    }
    return rows;
}

/* Λ of stage k in place of its Λ̂. */
static void costates_in_front(const Window *s, integer k)
{
    const Work *o = &s->work;
    const integer n = s->model.stride, n_r = s->model.n_r, most = (n_r + QUAD - 1) / QUAD * QUAD;
    real *Lambda = o->costates, *taken = o->square;
    real *W_turned = o->rows_lagged, *M = W_turned + n * most, *X = M + n * most, *C = X + n * most;
    const integer rows = whitened_rows(s, k, W_turned, M);
    clear(X, rows * n);
    add_product(X, (Factor){W_turned, 1, rows}, Lambda, rows, n, n);
    clear(C, rows * rows);
    for (integer r = 0; r < rows; r++) C[r * (rows + 1)] = 1;
    add_product(C, (Factor){X, n, 1}, W_turned, rows, n, rows);
    for (integer i = 0; i < rows * rows; i++) C[i] *= -(real)0.5;
    add_product(X, (Factor){C, rows, 1}, M, rows, rows, n);
    clear(taken, n * n);
    add_product(taken, (Factor){M, 1, n}, X, n, rows, n);
    transpose(taken, o->turned, n);
    for (integer i = 0; i < n * n; i++) Lambda[i] -= taken[i] + o->turned[i];
}

/* The transpose of Fᵀ Λ, with F of the transition that leaves stage k, in place of Λ. */
static void through_transition(const Window *s, integer k)
{
    const Model *m = &s->model;
    const integer n = m->stride;
    const real *F = SLOT(s->work.F, k, s->nnz_F);
    real *Lambda = s->work.costates, *product = s->work.square;
    clear(product + m->n_x * n, (n - m->n_x) * n);
    for (integer i = 0; i < m->n_x; i++)
        for (integer c = 0; c < n; c++) product[i * n + c] = m->F_unit[i] * Lambda[i * n + c];
    for (integer i = 0; i < m->n_x; i++)
        for (integer j = m->F_at[i]; j < m->F_at[i + 1]; j++)
            add_row(product + m->F_column[j] * n, F[j], Lambda + i * n, n);
    transpose(product, Lambda, n);
}

/* Λ̂ of the newest stage. */
static void begin_costates(const Window *s)
{
    clear(s->work.costates, s->model.stride * s->model.stride);
}

/* Λ̂ of stage k - 1 in place of that of stage k. */
static void costates_before(const Window *s, integer k)
{
    costates_in_front(s, k);
    through_transition(s, k - 1);
    through_transition(s, k - 1);
}

/* P_s (n_x, n_x) of stage k, from its Λ̂. What rounding leaves of P⁺ is its least. */
static void smoothed_covariance(const Window *s, integer k, real *P_s)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n = m->stride;
    real *P = o->P_told, *left = o->square, *taken = o->turned;
    covariance_of(m, SLOT(o->P_plus, k, m->n_P), P_s);
    clear(P, n * n);
    for (integer i = 0; i < n_x; i++) copy(P + i * n, P_s + i * n_x, n_x);
    clear(taken, n * n);
    add_product(taken, (Factor){P, n, 1}, o->costates, n, n, n);
    for (integer i = 0; i < n * n; i++) taken[i] = -taken[i];
    copy(left, P, n * n);
    add_product(left, (Factor){taken, n, 1}, P, n, n, n);
    for (integer i = 0; i < n_x; i++) {
        for (integer j = 0; j <= i; j++)
            P_s[i * n_x + j] = P_s[j * n_x + i] = (left[i * n + j] + left[j * n + i]) / 2;
        const real least = LEAST_SHARE * P[i * (n + 1)];
        if (P_s[i * (n_x + 1)] < least) P_s[i * (n_x + 1)] = least;
    }
}
