/* Householder's reflections, on an array that is kept column by column. Behind
 * estimation/linearise.c. */

/* Turn the columns from `row` on of an array so that this row's tail becomes zero and its head, on
 * the diagonal, a length; rows below turn along. Householder's reflection with its first column's
 * sign turned round: no branch on the sign, and nothing cancels. */
static inline void reflect(const Model *m, integer n_rows, integer width, integer row)
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

/* S of the array's first columns, S S' their product with their transpose. */
static inline void triangular(const Model *m, integer width, real *S)
{
    const integer n = N_X;
    for (integer i = 0; i < n; i++) reflect(m, n, width, i);
    for (integer i = 0; i < n; i++)
        for (integer j = 0; j < LD; j++) S[i * LD + j] = j > i ? 0 : m->array[j * n + i];
}
