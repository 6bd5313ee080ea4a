/* Bounds and inequalities by the dual active-set method of Goldfarb and Idnani on the multipliers
 * ν ≥ 0 of rows g + C' δ ≤ 0; mhe/interpreted/active_set.py says how. Behind mhe/compiled/smoother.c.
 *
 * Rows are counted through the window, row i = k n_c + j. `value` is g + C' δ_s at the present
 * multipliers, column a of `response` what a unit of the multiplier of row set[a] takes from all
 * values: one sweep through the factors, no new pass. */

#define NO_ROW (-1)

/* Rows and their derivatives at a trajectory's stages. */
static void constrain(const Window *s, const real *memory, const real *x)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x, n_c = s->n_c;
    for (integer k = 0; k < count; k++) {
        const real *arguments[] = {STAGE(x, k, n_x)};
        real *results[] = {STAGE(o->row_g, k, n_c), STAGE(o->row_C, k, n_c * n_x)};
        call(&s->model, &s->constrain, arguments, results);
    }
}

/* Sum over the stages of what a trajectory exceeds each row by, (n_c,); returns the largest excess
 * in standard deviations `row_std` where these are wanted. */
static real exceed(const Window *s, const real *memory, const real *x, real *violation,
                   const real *row_std)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_c = s->n_c;
    const real *demanded = memory + s->memory.demanded;
    real most = 0;
    for (integer j = 0; j < n_c; j++) violation[j] = 0;
    for (integer k = 0; k < count; k++) {
        const real *arguments[] = {STAGE(x, k, s->model.n_x)};
        real *results[] = {o->row_try, 0};
        call(&s->model, &s->constrain, arguments, results);
        for (integer j = 0; j < n_c; j++) {
            if (demanded[k * n_c + j] == 0 || !(o->row_try[j] > 0)) continue;
            violation[j] += o->row_try[j];
            if (row_std) most = fmax(most, o->row_try[j] / row_std[k * n_c + j]);
        }
    }
    return most;
}

/* Value of a row at the deviations d_s. */
static inline real row_value(const Window *s, integer i)
{
    const Work *o = &s->work;
    const integer n_x = s->model.n_x;
    return o->row_g[i] + dot(STAGE(o->row_C, i, n_x), STAGE(o->d_s, i / s->n_c, n_x), n_x);
}

/* Whether no row is marked active and the free optimum exceeds none. */
static int is_free(const Window *s, const real *memory)
{
    const integer n_rows = (integer)memory[s->memory.count] * s->n_c;
    const real *active = memory + s->memory.active, *demanded = memory + s->memory.demanded;
    for (integer i = 0; i < n_rows; i++)
        if (active[i] != 0 || (demanded[i] != 0 && row_value(s, i) > 0)) return 0;
    return 1;
}

/* Values of all rows without multipliers, P⁺ C, and standard deviations sqrt(C' P⁺ C). */
static void evaluate_rows(const Window *s, const real *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_c = s->n_c;
    for (integer k = 0; k < count; k++)
        for (integer j = 0; j < n_c; j++) {
            const integer i = k * n_c + j;
            const real *C = STAGE(o->row_C, i, n_x);
            real *PC = STAGE(o->row_PC, i, n_x);
            spread(m, SLOT(o->P_plus, k, s->model.n_P), C, PC);
            o->row_free[i] = row_value(s, i);
            o->row_std[i] = sqrt(fmax(dot(C, PC, n_x), 0));
        }
}

/* What a unit multiplier of row i takes from the values of all rows. */
static void respond(const Window *s, const real *memory, const real *noise_scale, integer i,
                    real *response)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const integer n_c = s->n_c, at = i / n_c;
    memset(o->d_shift, 0, (size_t)((at + 1) * n_x) * sizeof(real));
    memset(o->e_shift, 0, (size_t)((at + 1) * n_r) * sizeof(real));
    for (integer a = 0; a < n_x; a++) o->shift[a] = -STAGE(o->row_PC, i, n_x)[a];
    for (integer k = at + 1; k < count; k++) {
        real *d_shift = STAGE(o->d_shift, k, n_x);
        propagate(s, k, o->shift, STAGE(o->e_shift, k, n_r), d_shift);
        copy(o->shift, d_shift, n_x);
    }
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(real));
    for (integer k = count - 1; k >= 0; k--) {
        if (k < count - 1) retreat(s, k, o->lambda, noise_scale, o->lambda_hat, 0);
        if (k == at)
            for (integer a = 0; a < n_x; a++) o->lambda_hat[a] += STAGE(o->row_C, i, n_x)[a];
        for (integer j = k * n_c; j < (k + 1) * n_c; j++)
            response[j] = dot(STAGE(o->row_PC, j, n_x), o->lambda_hat, n_x)
                          - dot(STAGE(o->row_C, j, n_x), STAGE(o->d_shift, k, n_x), n_x);
        absorb(s, k, o->lambda_hat, STAGE(o->e_shift, k, n_r), o->e_pushed, o->lambda);
    }
}

/* One more row in the set's Cholesky factor; 0 where it depends on the others. `set` and
 * `response` hold it already, as number a. */
static int factorise(const Window *s, integer a, integer n_rows)
{
    const Work *o = &s->work;
    const integer most = s->most_active, *set = o->set;
    real *L = o->set_factor + a * most;
    for (integer b = 0; b < a; b++)
        L[b] = (o->response[b * n_rows + set[a]] - dot(L, o->set_factor + b * most, b))
               / o->set_factor[b * most + b];
    const real own = o->response[a * n_rows + set[a]], left = own - dot(L, L, a);
    if (!(left > DEPENDENT * own)) return 0;
    L[a] = sqrt(left);
    return 1;
}

/* Solve (L L') z = z in place, of the set's first `held` rows. */
static void solve_set(const Window *s, integer held, real *z)
{
    const real *L = s->work.set_factor;
    const integer most = s->most_active;
    for (integer a = 0; a < held; a++) z[a] = (z[a] - dot(L + a * most, z, a)) / L[a * most + a];
    for (integer a = held - 1; a >= 0; a--) {
        for (integer b = a + 1; b < held; b++) z[a] -= L[b * most + a] * z[b];
        z[a] /= L[a * most + a];
    }
}

/* Take row number a out of the set. Returns how many are left. */
static integer release(const Window *s, integer a, integer held, integer n_rows)
{
    const Work *o = &s->work;
    for (integer b = a; b + 1 < held; b++) {
        o->set[b] = o->set[b + 1];
        o->multiplier[b] = o->multiplier[b + 1];
        copy(o->response + b * n_rows, o->response + (b + 1) * n_rows, n_rows);
    }
    held--;
    for (integer b = a; b < held; b++) factorise(s, b, n_rows);
    return held;
}

/* Values of all rows at the present multipliers. */
static void reckon(const Window *s, integer held, integer n_rows)
{
    const Work *o = &s->work;
    copy(o->row_value, o->row_free, n_rows);
    for (integer a = 0; a < held; a++)
        for (integer i = 0; i < n_rows; i++)
            o->row_value[i] -= o->response[a * n_rows + i] * o->multiplier[a];
}

/* Begin with the rows that are marked active: the largest part of them whose multipliers are not
 * negative. Returns how many. */
static integer begin(const Window *s, const real *memory, const real *noise_scale, integer n_rows)
{
    const Work *o = &s->work;
    const real *active = memory + s->memory.active, *demanded = memory + s->memory.demanded;
    integer held = 0;
    for (integer i = 0; i < n_rows && held < s->most_active; i++) {
        if (active[i] == 0 || demanded[i] == 0) continue;
        o->set[held] = i;
        respond(s, memory, noise_scale, i, o->response + held * n_rows);
        held += factorise(s, held, n_rows);
    }
    while (held > 0) {
        integer worst = NO_ROW;
        for (integer a = 0; a < held; a++) o->multiplier[a] = o->row_free[o->set[a]];
        solve_set(s, held, o->multiplier);
        for (integer a = 0; a < held; a++)
            if (o->multiplier[a] < 0 && (worst < 0 || o->multiplier[a] < o->multiplier[worst]))
                worst = a;
        if (worst < 0) break;
        held = release(s, worst, held, n_rows);
    }
    return held;
}

/* The row that is exceeded most, in standard deviations; NO_ROW where all hold. */
static integer most_exceeded(const Window *s, const real *memory, integer held, integer n_rows)
{
    const Work *o = &s->work;
    const real *demanded = memory + s->memory.demanded;
    integer worst = NO_ROW;
    real most = EXCESS;
    for (integer i = 0; i < n_rows; i++) {
        if (demanded[i] == 0 || !(o->row_value[i] > most * o->row_std[i])) continue;
        integer a = 0;
        while (a < held && o->set[a] != i) a++;
        if (a < held || !(o->row_std[i] > 0)) continue;
        worst = i;
        most = o->row_value[i] / o->row_std[i];
    }
    return worst;
}

/* Multipliers of the linearised window's optimum, from its free one in `d_s`: the set, its
 * multipliers, how many in `held`, whether the set is another than was marked in `changed`. The
 * marks are made anew. */
static integer find_active_set(const Window *s, real *memory, const real *noise_scale,
                               integer *held, int *changed)
{
    const Work *o = &s->work;
    const integer n_rows = (integer)memory[s->memory.count] * s->n_c;
    real *active = memory + s->memory.active;
    integer status = 0, n = 0, p;
    evaluate_rows(s, memory);
    n = begin(s, memory, noise_scale, n_rows);
    reckon(s, n, n_rows);
    for (integer turn = 0; (p = most_exceeded(s, memory, n, n_rows)) != NO_ROW; turn++) {
        if (n == s->most_active || turn == MOST_CHANGES * n_rows) {
            status = STATUS_SOLVER_FAILED;
            break;
        }
        real taken = 0, left = o->row_value[p];
        respond(s, memory, noise_scale, p, o->response + n * n_rows);
        for (;;) { /* raise p's multiplier until the row holds; one that would fall below 0 goes */
            real *own = o->response + n * n_rows, curvature = own[p], most = INFINITY;
            integer blocking = NO_ROW;
            for (integer a = 0; a < n; a++) o->step[a] = own[o->set[a]];
            solve_set(s, n, o->step);
            for (integer a = 0; a < n; a++) {
                curvature -= own[o->set[a]] * o->step[a];
                if (!(o->step[a] > 0) || !(o->multiplier[a] / o->step[a] < most)) continue;
                most = o->multiplier[a] / o->step[a];
                blocking = a;
            }
            const int free = curvature > DEPENDENT * own[p];
            const real whole = free ? left / curvature : INFINITY, t = fmin(most, whole);
            if (!isfinite(t)) { /* no state meets this row beside those in the set */
                status = STATUS_INFEASIBLE;
                break;
            }
            for (integer a = 0; a < n; a++) o->multiplier[a] -= t * o->step[a];
            taken += t;
            left -= t * (free ? curvature : 0);
            if (t < most) break;
            release(s, blocking, n, n_rows);
            copy(o->response + (n - 1) * n_rows, own, n_rows);
            n--;
        }
        if (status) break;
        o->set[n] = p;
        o->multiplier[n] = taken;
        if (!factorise(s, n, n_rows)) {
            status = STATUS_SOLVER_FAILED;
            break;
        }
        n++;
        for (integer a = 0; a < n; a++) o->multiplier[a] = o->row_free[o->set[a]];
        solve_set(s, n, o->multiplier); /* afresh: no rounding piles up */
        for (integer a = 0; a < n; a++) o->multiplier[a] = fmax(o->multiplier[a], 0);
        reckon(s, n, n_rows);
    }
    memset(o->is_held, 0, (size_t)n_rows * sizeof(real));
    for (integer a = 0; a < n; a++) o->is_held[o->set[a]] = 1;
    *changed = memcmp(o->is_held, active, (size_t)n_rows * sizeof(real)) != 0;
    copy(active, o->is_held, n_rows);
    *held = n;
    return status;
}

/* The pass back with the multipliers of the set. Returns the squared length of its step. */
static real held_backward(const Window *s, const real *memory, const real *w,
                          const real *noise_scale, integer held, real *g)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x, n_c = s->n_c;
    integer first = count;
    memset(o->impulse, 0, (size_t)(count * n_x) * sizeof(real));
    for (integer a = 0; a < held; a++) {
        const integer i = o->set[a], k = i / n_c;
        for (integer b = 0; b < n_x; b++)
            STAGE(o->impulse, k, n_x)[b] += o->multiplier[a] * STAGE(o->row_C, i, n_x)[b];
        if (k < first) first = k;
    }
    push(s, count, first);
    return backward(s, memory, w, noise_scale, PUSHED, g);
}

/* Rounding leaves rows of the set a little off: correct their multipliers, and go back again, until
 * all are met to a share of the step's length, and off by less than would bend the slope of the
 * cost along it. Returns the squared length of the step, NAN where they will not be met. */
static real refine(const Window *s, const real *memory, const real *w, const real *noise_scale,
                   integer held, real length, real *g)
{
    const Work *o = &s->work;
    for (int turn = 0;; turn++) {
        real most = 0, bent = 0;
        for (integer a = 0; a < held; a++) {
            o->step[a] = row_value(s, o->set[a]);
            most = fmax(most, fabs(o->step[a]) / o->row_std[o->set[a]]);
            bent += fabs(o->step[a] * o->multiplier[a]);
        }
        if (most <= MET || (most <= ENOUGH * sqrt(length) && bent <= ENOUGH * length))
            return length;
        if (turn == MOST_REFINEMENTS) return NAN;
        solve_set(s, held, o->step);
        for (integer a = 0; a < held; a++) o->multiplier[a] += o->step[a];
        length = held_backward(s, memory, w, noise_scale, held, g);
    }
}

/* Where rows are exceeded or held: from the free optimum of the linearised window, whose squared
 * step length is given, to the one that meets them. */
static integer meet_constraints(const Window *s, real *memory, const real *w,
                                const real *noise_scale, real *length, real *g, integer *held,
                                int *changed)
{
    *held = 0;
    *changed = 0;
    if (is_free(s, memory)) return 0;
    integer status = find_active_set(s, memory, noise_scale, held, changed);
    if (*held > 0) {
        *length = held_backward(s, memory, w, noise_scale, *held, g);
        const real refined = refine(s, memory, w, noise_scale, *held, *length, g);
        if (isfinite(refined)) *length = refined;
    }
    return status;
}
