/* Descent to the window's optimum; mhe/descent.py says how. Behind mhe/pass.c. */

/* Roll the trajectory of z_try = (μ, w_0, w_1, …) out through the model, from
 * x_0 = x̄ ⊞ P̄ μ, and return its cost. */
static real try_cost(const Window *s, const real *memory, real *row_scale,
                       real *noise_scale)
{
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = s->model.n_x;
    const real *P = memory + s->memory.prior_covariance, *w = o->z_try + n_x;
    for (integer i = 0; i < n_x; i++) o->d_try[i] = dot(P + i * n_x, o->z_try, n_x);
    retract(&s->model, memory + s->memory.prior_mean, o->d_try, o->x_try);
    for (integer k = 0; k + 1 < count; k++)
        move(s, STAGE(o->x_try, k, n_x), STAGE(w, k, s->model.n_w), interval(s, memory, k),
             STAGE(o->x_try, k + 1, n_x));
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

/* Gauss-Newton passes to convergence; see mhe/descent.py. Writes trajectory and cost, and
 * counts iterations on. */
static integer descend(const Window *s, real *memory, real *cost, real *iterations)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x;
    const integer n_noises = (count - 1) * m->n_w, n_z = n_x + n_noises;
    const real *P = memory + s->memory.prior_covariance;
    const real began = seconds();
    real *x = memory + s->memory.x, *w = memory + s->memory.w;
    real *row_scale = o->row_scale, *noise_scale = o->noise_scale;
    real *row_scale_try = o->row_scale_try, *noise_scale_try = o->noise_scale_try;

    difference(s, x, memory + s->memory.prior_mean, o->d);
    copy(o->z_next + n_x, w, n_noises);
    const real distance = prior_multiplier(s, P, o->d, o->z_next);
    const real readings = measure(s, memory, x, w, row_scale, noise_scale);
    (*iterations)++;
    if (!isfinite(readings)) {
        forward(s, memory, o->d, row_scale, noise_scale); /* the covariance is this window's */
        return STATUS_NOT_FINITE;
    }
    real J = readings + distance / 2, base = INFINITY, alpha = 1;
    int depth = -1, settling = 0, accelerated = 0;
    for (;; (*iterations)++) {
        const real squares = forward(s, memory, o->d, row_scale, noise_scale);
        real length = backward(s, memory, noise_scale, o->g_next), J_try = NAN;
        if (!isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
        for (integer i = 0; i < n_x; i++) o->f[i] = o->g_next[i] - o->z_next[i];
        for (integer i = 0; i < n_x; i++) length += o->f[i] * dot(P + i * n_x, o->f, n_x);
        const int over = *iterations >= s->most_iterations ? STATUS_ITERATION_LIMIT
                         : seconds() - began > s->most_seconds ? STATUS_TIME_LIMIT : 0;

        if (settling && !(length < base)) { /* the cost cannot tell, the step's length can */
            alpha = accelerated ? 1 : alpha / 2;
            accelerated = 0;
            part_way(o, alpha, n_z);
            const int stuck = alpha < SHORTEST_SETTLING;
            if (over || stuck) copy(o->z_try, o->z, n_z);
            J = try_cost(s, memory, row_scale_try, noise_scale_try);
            if (over || stuck) {
                copy(x, o->x_try, count * n_x);
                copy(w, o->z_try + n_x, n_noises);
                *cost = J;
                return sqrt(base) <= FLOOR ? 0 : over ? over : STATUS_SOLVER_FAILED;
            }
        } else {
            copy(o->z_2, o->z_1, n_z), copy(o->g_2, o->g_1, n_z);
            copy(o->z_1, o->z, n_z), copy(o->g_1, o->g, n_z);
            copy(o->z, o->z_next, n_z), copy(o->g, o->g_next, n_z);
            depth = depth < 2 ? depth + 1 : 2;
            base = length;
            alpha = 1;
            *cost = J;
            const int last = sqrt(length) <= s->tolerance;
            if (s->most_iterations == 0 && !last) return STATUS_ITERATION_LIMIT;
            settling = isfinite(J) && length / 2 < RESOLUTION * fmax(1.0, fabs(J));
            const real slack = ROUNDING * fmax(1.0, fabs(J));
            accelerated = !last && depth > 0 && sqrt(length) < GATE
                          && accelerate(s, memory, depth, n_z);
            if (accelerated) {
                J_try = try_cost(s, memory, row_scale_try, noise_scale_try);
                if (!(settling ? isfinite(J_try) : J_try <= J - SUFFICIENT * length))
                    accelerated = 0;
            }
            if (!accelerated)
                for (;; alpha /= 2) {
                    if (alpha < SHORTEST_STEP) return STATUS_SOLVER_FAILED;
                    part_way(o, alpha, n_z);
                    J_try = try_cost(s, memory, row_scale_try, noise_scale_try);
                    const int falls = J_try <= J - SUFFICIENT * alpha * length + slack;
                    if (isfinite(J_try) && (settling || last || falls)) break;
                }
            J = J_try;
            if (last) {
                copy(x, o->x_try, count * n_x);
                copy(w, o->z_try + n_x, n_noises);
                copy(o->d, o->d_try, n_x);
                *cost = J;
                return 0;
            }
        }
        copy(x, o->x_try, count * n_x);
        copy(w, o->z_try + n_x, n_noises);
        copy(o->d, o->d_try, n_x);
        copy(o->z_next, o->z_try, n_z);
        *cost = J;
        if (over) return over;
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
        if (fabs(o->d[i] - o->d_try[i]) > WOUND * fmax(1.0, fabs(o->d[i]))) return 1;
    return 0;
}

/* Descend, and again from there where an angle went round. */
static integer converge(const Window *s, real *memory, real *cost, real *iterations)
{
    *iterations = 0;
    integer status = descend(s, memory, cost, iterations);
    for (int turn = 0; turn < MOST_TURNS && status == 0 && is_wound(s, memory); turn++)
        status = descend(s, memory, cost, iterations);
    return status;
}
