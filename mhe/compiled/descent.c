/* Descent to the window's optimum; mhe/interpreted/descent.py says how. Behind mhe/compiled/active_set.c. */

/* The multiplier μ of a deviation d = P̄ μ from the prior mean, by a Cholesky factor of P̄.
 * Only the first guess of a window needs it: every later deviation is P̄ times something.
 * Returns d' P̄⁻¹ d; where there is no factor, infinity, and μ is zero. */
static real prior_multiplier(const Window *s, const real *P, const real *d, real *mu)
{
    const integer n = s->model.n_x, stride = s->model.stride;
    real *L = s->work.L_prior, sum = 0;
    memset(mu, 0, (size_t)n * sizeof(real));
    for (integer i = 0; is_root(P) && i < n; i++) copy(L + i * n, P + i * stride, n);
    for (integer i = 0; !is_root(P) && i < n; i++)
        for (integer j = 0; j <= i; j++) {
            const real left = P[i * stride + j] - dot(L + i * n, L + j * n, j);
            if (i == j && !(left > 0)) return INFINITY;
            L[i * n + j] = i == j ? sqrt(left) : left / L[j * n + j];
        }
    for (integer i = 0; i < n; i++)
        if (L[i * (n + 1)] == 0) return INFINITY;
    for (integer i = 0; i < n; i++) {
        mu[i] = (d[i] - dot(L + i * n, mu, i)) / L[i * n + i];
        sum += mu[i] * mu[i];
    }
    for (integer i = n - 1; i >= 0; i--) {
        for (integer j = i + 1; j < n; j++) mu[i] -= L[j * n + i] * mu[j];
        mu[i] /= L[i * n + i];
    }
    return sum;
}

/* Inner product of two vectors (μ, w_0, w_1, …) in units of the whitened problem. */
static real inner(const Window *s, const real *memory, const real *a, const real *b)
{
    const integer n = s->model.n_x, noises = ((integer)memory[s->memory.count] - 1) * s->model.n_w;
    const real *P = memory + s->memory.prior_covariance;
    real sum = dot(a + n, b + n, noises);
    spread(&s->model, P, b, s->work.spread);
    return sum + dot(a, s->work.spread, n);
}

/* Roll the trajectory of z_try = (μ, w_0, w_1, …) out through the model, from
 * x_0 = x̄ ⊞ P̄ μ, and return its cost. What it exceeds rows by goes to `violation_try`. */
static real try_cost(const Window *s, const real *memory, real *row_scale,
                       real *noise_scale)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    const real *P = memory + s->memory.prior_covariance, *w = o->z_try + n_x;
    spread(&s->model, P, o->z_try, o->d_try);
    retract(&s->model, memory + s->memory.prior_mean, o->d_try, o->x_try);
    for (integer k = 0; k + 1 < count; k++)
        move(s, memory, k, STAGE(o->x_try, k, n_x), STAGE(w, k, s->model.n_w),
             STAGE(o->x_try, k + 1, n_x));
    if (s->n_c > 0) exceed(s, memory, o->x_try, o->violation_try, 0);
    return measure(s, memory, o->x_try, w, row_scale, noise_scale)
           + dot(o->z_try, o->d_try, n_x) / 2;
}

/* z_try = z + α (g - z). */
static void part_way(const Work *o, real alpha, integer n)
{
    for (integer i = 0; i < n; i++) o->z_try[i] = (1 - alpha) * o->z[i] + alpha * o->g[i];
}

/* Anderson acceleration: z_try = g - γ₁ (g - g₁) - γ₂ (g₁ - g₂), with the γ that make the
 * step f = g - z shortest to first order, f - γ₁ (f - f₁) - γ₂ (f₁ - f₂). `depth` of the two
 * earlier points are known; returns whether there is such a γ. */
static int accelerate(const Window *s, const real *memory, int depth, integer n)
{
    const Work *o = &s->work;
    for (integer i = 0; i < n; i++) {
        o->f[i] = o->g[i] - o->z[i];
        o->f_1[i] = o->f[i] - (o->g_1[i] - o->z_1[i]);
        o->f_2[i] = depth > 1 ? o->g_1[i] - o->z_1[i] - (o->g_2[i] - o->z_2[i]) : 0.0;
    }
    const real a = inner(s, memory, o->f_1, o->f_1), c = inner(s, memory, o->f_2, o->f_2);
    const real b = inner(s, memory, o->f_1, o->f_2);
    const real left = inner(s, memory, o->f_1, o->f), right = inner(s, memory, o->f_2, o->f);
    const real determinant = a * c - b * b;
    real gamma_1, gamma_2 = 0;
    if (determinant > SINGULAR * a * c) {
        gamma_1 = (c * left - b * right) / determinant;
        gamma_2 = (a * right - b * left) / determinant;
    } else if (a > 0)
        gamma_1 = left / a;
    else
        return 0;
    for (integer i = 0; i < n; i++) {
        o->z_try[i] = o->g[i] - gamma_1 * (o->g[i] - o->g_1[i]);
        if (gamma_2 != 0) o->z_try[i] -= gamma_2 * (o->g_1[i] - o->g_2[i]);
    }
    return 1;
}

/* Raise the weights of violations above all multipliers: the merit's slope is then as steep as
 * the cost's would be without constraints. */
static void weigh_violations(const Window *s, integer held)
{
    const Work *o = &s->work;
    for (integer a = 0; a < held; a++) {
        real *weight = o->weight + o->set[a] % s->n_c;
        *weight = fmax(*weight, 2 * o->multiplier[a]);
    }
}

/* Whether the set of the pass before still is the right one, after a pass with its rows HELD: no
 * multiplier negative, no other row exceeded. The multipliers go to the set. */
static int is_right(const Window *s, const real *memory, integer held)
{
    const Work *o = &s->work;
    const integer n_rows = (integer)memory[s->memory.count] * s->n_c;
    const real *demanded = memory + s->memory.demanded;
    for (integer a = 0; a < held; a++) {
        o->multiplier[a] = o->row_multiplier[o->set[a]];
        if (!(o->multiplier[a] >= 0)) return 0;
    }
    for (integer i = 0; i < n_rows; i++)
        if (demanded[i] != 0 && o->is_held[i] == 0 && row_value(s, i) > EXCESS * o->row_std[i])
            return 0;
    return 1;
}

/* The linearised window's optimum around x, rows met; `held` rows hold it, as many as held the
 * one before when it is called, 0 for the first. Returns its status; `length` is the
 * squared length of the step to it, prior included. */
static integer linearise(const Window *s, real *memory, const real *row_scale,
                         const real *noise_scale, real *length, integer *held, int *changed)
{
    const Work *o = &s->work;
    const Memory *at = &s->memory;
    const integer n_x = s->model.n_x;
    const real *x = memory + at->x, *w = memory + at->w, *P = memory + at->prior_covariance;
    integer status = 0;
    for (integer i = 0; i < n_x; i++) o->deviation[i] = -o->d[i];
    *changed = 0;
    if (s->n_c > 0) constrain(s, memory, x);
    if (*held > 0) { /* as by the set of the pass before: mostly it still is the right one */
        const real squares = forward(s, memory, o->deviation, x, w, row_scale, noise_scale, 1);
        *length = isfinite(squares) ? backward(s, memory, w, noise_scale, HELD, o->g_next) : NAN;
        if (!isfinite(*length) || !is_right(s, memory, *held)) *held = 0;
    }
    if (*held == 0) {
        const real squares = forward(s, memory, o->deviation, x, w, row_scale, noise_scale, 0);
        *length = backward(s, memory, w, noise_scale, FREE, o->g_next);
        if (!isfinite(squares) || !isfinite(*length)) return STATUS_NOT_FINITE;
        if (s->n_c > 0)
            status = meet_constraints(s, memory, w, noise_scale, length, o->g_next, held, changed);
    }
    if (!isfinite(*length)) return STATUS_NOT_FINITE;
    if (*held > 0) weigh_violations(s, *held);
    for (integer i = 0; i < n_x; i++) o->f[i] = o->g_next[i] - o->z_next[i];
    spread(&s->model, P, o->f, o->spread);
    *length += dot(o->f, o->spread, n_x);
    return status;
}

/* The candidate becomes the trajectory. */
static void take(const Window *s, real *memory, integer n_noises)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    copy(memory + s->memory.x, o->x_try, count * n_x);
    copy(memory + s->memory.w, o->z_try + n_x, n_noises);
    memory[s->memory.apart] = 0;
    copy(o->d, o->d_try, n_x);
    copy(o->violation, o->violation_try, s->n_c);
}

/* Whether the states follow from each other: not where a late reading was put between two, nor where
 * a prediction beyond a bound was moved inside. Such a start costs nothing that a step could be held
 * against. */
static int is_rolled_out(const Window *s, const real *memory)
{
    const integer newest = (integer)memory[s->memory.count] - 1, n_x = s->model.n_x;
    const real *x = memory + s->memory.x, *w = memory + s->memory.w;
    if (memory[s->memory.apart] != 0) return 0;
    if (s->n_c == 0 || newest == 0) return 1;
    move(s, memory, newest - 1, STAGE(x, newest - 1, n_x), STAGE(w, newest - 1, s->model.n_w),
         s->work.reached);
    return same(s->work.reached, STAGE(x, newest, n_x), n_x);
}

/* Gauss-Newton passes to convergence; see mhe/interpreted/descent.py. Writes trajectory and cost, and counts
 * passes on; stops before a pass that would end too late. */
static integer descend(const Window *s, real *memory, double start, Solved *solved)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_c = s->n_c;
    const integer n_noises = (count - 1) * m->n_w, n_z = n_x + n_noises;
    const real *P = memory + s->memory.prior_covariance;
    const real *x = memory + s->memory.x, *w = memory + s->memory.w;
    real *row_scale = o->row_scale, *noise_scale = o->noise_scale;
    real *row_scale_try = o->row_scale_try, *noise_scale_try = o->noise_scale_try;

    difference(s, x, memory + s->memory.prior_mean, o->d);
    copy(o->z_next + n_x, w, n_noises);
    const real distance = prior_multiplier(s, P, o->d, o->z_next);
    const real readings = measure(s, memory, x, w, row_scale, noise_scale);
    if (n_c > 0) exceed(s, memory, x, o->violation, 0);
    memset(o->weight, 0, (size_t)n_c * sizeof(real));
    solved->passes++;
    if (!isfinite(readings)) {
        for (integer i = 0; i < n_x; i++) o->deviation[i] = -o->d[i];
        /* for its covariance */
        forward(s, memory, o->deviation, x, w, row_scale, noise_scale, 0);
        return STATUS_NOT_FINITE;
    }
    real J = is_rolled_out(s, memory) ? readings + distance / 2 : INFINITY;
    real base = INFINITY, alpha = 1, last_ratio = 1;
    integer failed = 0, held = 0;
    int depth = -1, settling = 0, accelerated = 0, changed = 0;
    for (;; solved->passes++) {
        const double began = now(s);
        real length = 0, J_try = NAN;
        failed = linearise(s, memory, row_scale, noise_scale, &length, &held, &changed);
        if (failed == STATUS_NOT_FINITE) return failed;
        const int limited = solved->passes >= s->most_iterations;

        if (settling && !(length < base)) { /* the cost cannot tell, the step's length can */
            const int over = limited ? STATUS_ITERATION_LIMIT
                                     : affordable(s, start) < count ? STATUS_TIME_LIMIT : 0;
            alpha = accelerated ? 1 : alpha / 2;
            accelerated = 0;
            part_way(o, alpha, n_z);
            const int stuck = alpha < SHORTEST_SETTLING;
            if (over || stuck) copy(o->z_try, o->z, n_z);
            J = try_cost(s, memory, row_scale_try, noise_scale_try);
            if (over || stuck) {
                take(s, memory, n_noises);
                solved->cost = J;
                return sqrt(base) <= FLOOR ? 0 : over ? over : STATUS_SOLVER_FAILED;
            }
        } else {
            copy(o->z_2, o->z_1, n_z), copy(o->g_2, o->g_1, n_z);
            copy(o->z_1, o->z, n_z), copy(o->g_1, o->g, n_z);
            copy(o->z, o->z_next, n_z), copy(o->g, o->g_next, n_z);
            depth = changed ? 0 : depth < 2 ? depth + 1 : 2;
            const real ratio = changed || !isfinite(base) ? 1 : sqrt(length / base);
            const real shrinks = fmax(ratio, last_ratio); /* the worse of two, 1 if not known */
            last_ratio = ratio;
            base = length;
            alpha = 1;
            solved->cost = J;
            solved->kkt = sqrt(length);
            const int last = sqrt(length) <= s->tolerance
                             || shrinks * sqrt(length) <= s->tolerance;
            if (s->most_iterations == 0 && !last) return failed | STATUS_ITERATION_LIMIT;
            const real level = J + dot(o->weight, o->violation, n_c);
            settling = isfinite(level) && length / 2 < RESOLUTION * fmax(1, fabs(level));
            const real slack = ROUNDING * fmax(1, fabs(level));
            accelerated = !last && depth > 0 && sqrt(length) < GATE
                          && accelerate(s, memory, depth, n_z);
            if (accelerated) {
                J_try = try_cost(s, memory, row_scale_try, noise_scale_try);
                const real tried = J_try + dot(o->weight, o->violation_try, n_c);
                if (!(settling ? isfinite(tried) : tried <= level - SUFFICIENT * length))
                    accelerated = 0;
            }
            if (!accelerated)
                for (;; alpha /= 2) {
                    if (alpha < SHORTEST_STEP) return failed | STATUS_SOLVER_FAILED;
                    part_way(o, alpha, n_z);
                    J_try = try_cost(s, memory, row_scale_try, noise_scale_try);
                    const real tried = J_try + dot(o->weight, o->violation_try, n_c);
                    const int falls = tried <= level - SUFFICIENT * alpha * length + slack;
                    if (isfinite(tried) && (settling || last || falls)) break;
                    if (n_c > 0 && alpha == 1 && isfinite(tried) && sqrt(length) < GATE) {
                        settling = 1; /* a curved row: its merit would shorten good steps */
                        break;
                    }
                }
            J = J_try;
            if (last) {
                take(s, memory, n_noises);
                solved->cost = J;
                return failed;
            }
        }
        take(s, memory, n_noises);
        copy(o->z_next, o->z_try, n_z);
        solved->cost = J;
        note_pass(s, count, began);
        if (failed) return failed;
        if (limited) return STATUS_ITERATION_LIMIT;
        if (affordable(s, start) < count) return STATUS_TIME_LIMIT;
        real *swap = row_scale;
        row_scale = row_scale_try, row_scale_try = swap;
        swap = noise_scale, noise_scale = noise_scale_try, noise_scale_try = swap;
    }
}

/* Whether the window's first state is nearer to the prior than the descent believes: an
 * angle went round on the way. */
static int is_wound(const Window *s, const real *memory)
{
    const Work *o = &s->work;
    difference(s, memory + s->memory.x, memory + s->memory.prior_mean, o->d_try);
    for (integer i = 0; i < s->model.n_x; i++)
        if (fabs(o->d[i] - o->d_try[i]) > WOUND * fmax(1, fabs(o->d[i]))) return 1;
    return 0;
}

/* After passes that were conditioned on rows: factors of the free problem at the trajectory, for the
 * covariance that is told. */
static void free_covariance(const Window *s, const real *memory)
{
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const real *x = memory + at->x, *w = memory + at->w;
    const real *row_scale = memory + at->present, *noise_scale = o->unit_noises;
    if (s->has_losses) {
        measure(s, memory, x, w, o->row_scale, o->noise_scale);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    for (integer i = 0; i < s->model.n_x; i++) o->deviation[i] = -o->d[i];
    forward(s, memory, o->deviation, x, w, row_scale, noise_scale, 0);
}

/* Descend, and again from there where an angle went round. */
static integer converge(const Window *s, real *memory, double start, Solved *solved)
{
    integer status = descend(s, memory, start, solved);
    for (int turn = 0; turn < MOST_TURNS && status == 0 && is_wound(s, memory); turn++)
        status = descend(s, memory, start, solved);
    if (s->n_c > 0) { /* rows that the trajectory itself does not meet, not its linearisation */
        const Work *o = &s->work;
        const real *x = memory + s->memory.x;
        solved->kkt = fmax(solved->kkt, exceed(s, memory, x, o->violation, o->row_std));
        if (o->ring[MADE] == 0) free_covariance(s, memory);
    }
    return status;
}
