/* The moving horizon: slide the window, Gauss-Newton passes, line search. Behind
 * estimation/engine.c; the structures Memory, Work and Window are declared in front.
 *
 * `memory` is the state: stages oldest first, `count` of them. Work arrays hold one entry
 * per stage of what the forward pass leaves for the backward pass. */

#define STAGE(array, k, width) ((array) + (k) * (width))

static void move(const Window *s, const double *x, const double *w, double dt, double *reached)
{
    const double *arguments[] = {x, w, &dt};
    double *results[] = {reached};
    s->move(arguments, results, 0, 0, 0);
}

static void retract(const Window *s, const double *x, const double *delta, double *moved)
{
    const double *arguments[] = {x, delta};
    double *results[] = {moved};
    s->retract(arguments, results, 0, 0, 0);
}

static void difference(const Window *s, const double *to, const double *from, double *delta)
{
    const double *arguments[] = {to, from};
    double *results[] = {delta};
    s->difference(arguments, results, 0, 0, 0);
}

static double interval(const Window *s, const double *memory, long long k)
{
    const double *times = memory + s->memory.times;
    return times[k + 1] - times[k];
}

/* d' P̄⁻¹ d by a Cholesky factor of P̄; infinite where there is none. Only the first guess of
 * a window needs it: everything after it is P̄ times something. */
static double prior_distance(const Window *s, const double *P, const double *d)
{
    const long long n = s->model.n_x;
    double *L = s->work.L_prior, *z = s->work.z, sum = 0;
    for (long long i = 0; i < n; i++) {
        for (long long j = 0; j <= i; j++) {
            double left = P[i * n + j] - dot(L + i * n, L + j * n, j);
            if (i == j && !(left > 0)) return INFINITY;
            L[i * n + j] = i == j ? sqrt(left) : left / L[j * n + j];
        }
        z[i] = (d[i] - dot(L + i * n, z, i)) / L[i * n + i];
        sum += z[i] * z[i];
    }
    return sum;
}

/* μ' P̄ μ, and P̄ μ. */
static double prior_energy(long long n, const double *P, const double *mu, double *P_mu)
{
    for (long long i = 0; i < n; i++) P_mu[i] = dot(P + i * n, mu, n);
    return dot(mu, P_mu, n);
}

/* Cost of readings and noises of a trajectory, and the scales by which its losses weigh
 * them; the prior's part is the caller's. */
static double measure(const Window *s, const double *memory, const double *x, const double *w,
                      double *row_scale, double *noise_scale)
{
    const Model *m = &s->model;
    const long long count = (long long)memory[s->memory.count];
    const double *y = memory + s->memory.y, *present = memory + s->memory.present;
    double cost = 0, part = 0;
    for (long long k = 0; k < count; k++) {
        const double *seen[] = {STAGE(x, k, m->n_x), STAGE(y, k, m->n_y),
                                STAGE(present, k, m->n_r), s->huber};
        double *scales[] = {STAGE(row_scale, k, m->n_r), &part};
        s->measure(seen, scales, 0, 0, 0);
        cost += part;
    }
    for (long long k = 0; k + 1 < count; k++) {
        const double *shaken[] = {STAGE(w, k, m->n_w), &s->huber_noise};
        double *scales[] = {STAGE(noise_scale, k, m->n_w), &part};
        s->shake(shaken, scales, 0, 0, 0);
        cost += part;
    }
    return cost;
}

/* Kalman stages over the window, linearised at its trajectory. Returns the sum of squared
 * whitened innovations. */
static double forward(const Window *s, const double *memory, const double *row_scale,
                      const double *noise_scale)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const double *x = memory + s->memory.x, *w = memory + s->memory.w;
    const double *y = memory + s->memory.y;
    const double *x_minus = memory + s->memory.prior_mean;
    const double *P_minus = memory + s->memory.prior_covariance;
    double squares = 0;
    for (long long k = 0; k < count; k++) {
        if (k > 0) {
            const double dt = interval(s, memory, k - 1);
            predict(m, STAGE(o->x_plus, k - 1, n_x), STAGE(o->P_plus, k - 1, n_x * n_x),
                    STAGE(x, k - 1, n_x), STAGE(w, k - 1, m->n_w), &dt,
                    STAGE(noise_scale, k - 1, m->n_w), o->x_minus, o->P_minus,
                    STAGE(o->F, k - 1, s->nnz_F), STAGE(o->G, k - 1, s->nnz_G));
            x_minus = o->x_minus;
            P_minus = o->P_minus;
        }
        const int newest = k == count - 1;
        double *updated[] = {STAGE(o->x_plus, k, n_x), STAGE(o->P_plus, k, n_x * n_x),
                             newest ? o->v : 0,        newest ? o->S : 0,
                             STAGE(o->W, k, n_x * n_r), STAGE(o->e, k, n_r),
                             STAGE(o->H, k, s->nnz_H), STAGE(o->L, k, s->nnz_L)};
        update(m, x_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_y),
               STAGE(row_scale, k, n_r), updated);
        squares += dot(STAGE(o->e, k, n_r), STAGE(o->e, k, n_r), n_r);
    }
    return squares;
}

/* Modified Bryson-Frazier pass back: smoothed states x_s, noises w_s, and the multiplier of
 * the prior in `mu`. Returns the squared length of the step in units of the whitened
 * problem, without the prior's part. */
static double backward(const Window *s, const double *memory, const double *noise_scale)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const long long n_w = m->n_w;
    const double *x = memory + s->memory.x, *w = memory + s->memory.w;
    double length = 0, part = 0;
    memset(o->lambda_hat, 0, (size_t)n_x * sizeof(double));
    for (long long k = count - 1; k >= 0; k--) {
        if (k < count - 1) {
            const double *ahead[] = {o->lambda, STAGE(o->F, k, s->nnz_F),
                                     STAGE(o->G, k, s->nnz_G), STAGE(noise_scale, k, n_w)};
            double *back[] = {o->lambda_hat, STAGE(o->w_s, k, n_w)};
            s->retreat(ahead, back, 0, 0, 0);
            for (long long i = 0; i < n_w; i++) {
                const double step = STAGE(o->w_s, k, n_w)[i] - STAGE(w, k, n_w)[i];
                const double scale = STAGE(noise_scale, k, n_w)[i];
                length += step * step / (scale * scale);
            }
        }
        const double *stage[] = {STAGE(o->x_plus, k, n_x),    STAGE(o->P_plus, k, n_x * n_x),
                                 o->lambda_hat,               STAGE(o->W, k, n_x * n_r),
                                 STAGE(o->e, k, n_r),         STAGE(o->L, k, s->nnz_L),
                                 STAGE(o->H, k, s->nnz_H),    STAGE(x, k, n_x)};
        double *smoothed[] = {STAGE(o->x_s, k, n_x), o->lambda, &part};
        s->smooth(stage, smoothed, 0, 0, 0);
        length += part;
    }
    for (long long i = 0; i < n_x; i++) o->mu[i] = -o->lambda[i];
    return length;
}

/* One pass: the linearised window's optimum becomes the trajectory. */
static long long one_pass(const Window *s, double *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count];
    double *x = memory + s->memory.x, *w = memory + s->memory.w;
    const double *row_scale = memory + s->memory.present, *noise_scale = o->unit_noises;
    if (s->has_losses) {
        if (!isfinite(measure(s, memory, x, w, o->row_scale, o->noise_scale)))
            return STATUS_NOT_FINITE;
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    const double squares = forward(s, memory, row_scale, noise_scale);
    const double length = backward(s, memory, noise_scale);
    if (!isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
    copy(x, o->x_s, count * m->n_x);
    copy(w, o->w_s, (count - 1) * m->n_w);
    return 0;
}

/* Trajectory a part `alpha` of the way to the pass's optimum, rolled out through the model:
 * x_0 = x̄ ⊞ d, d = (1 - α) d + α P̄ μ. */
static void roll_out(const Window *s, const double *memory, double alpha)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x, n_w = m->n_w;
    const double *w = memory + s->memory.w;
    for (long long i = 0; i < n_x; i++)
        o->d_try[i] = (1 - alpha) * o->d[i] + alpha * o->P_mu[i];
    retract(s, memory + s->memory.prior_mean, o->d_try, o->x_try);
    for (long long k = 0; k + 1 < count; k++) {
        double *noise = STAGE(o->w_try, k, n_w);
        for (long long i = 0; i < n_w; i++)
            noise[i] = (1 - alpha) * STAGE(w, k, n_w)[i] + alpha * STAGE(o->w_s, k, n_w)[i];
        move(s, STAGE(o->x_try, k, n_x), noise, interval(s, memory, k),
             STAGE(o->x_try, k + 1, n_x));
    }
}

/* Gauss-Newton passes with a backtracking line search on the window's cost, which therefore
 * never rises. Writes trajectory, cost and iterations. */
static long long converge(const Window *s, double *memory, double *cost, double *iterations)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long count = (long long)memory[s->memory.count], n_x = m->n_x;
    const double *P = memory + s->memory.prior_covariance;
    const double began = seconds();
    double *x = memory + s->memory.x, *w = memory + s->memory.w;
    double *row_scale = o->row_scale, *noise_scale = o->noise_scale;
    double *row_scale_try = o->row_scale_try, *noise_scale_try = o->noise_scale_try;

    difference(s, x, memory + s->memory.prior_mean, o->d);
    double distance = prior_distance(s, P, o->d);
    const double readings = measure(s, memory, x, w, row_scale, noise_scale);
    if (!isfinite(readings)) return STATUS_NOT_FINITE;
    double J = readings + distance / 2;
    int mu_known = 0;
    for (*iterations = 1;; (*iterations)++) {
        const double squares = forward(s, memory, row_scale, noise_scale);
        double length = backward(s, memory, noise_scale);
        if (!isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
        const double energy = prior_energy(n_x, P, o->mu, o->P_mu);
        const double product = dot(o->mu, o->d, n_x); /* d = P̄ μ_old, so this is μ' P̄ μ_old */
        if (mu_known) {
            for (long long i = 0; i < n_x; i++) o->z[i] = o->mu[i] - o->mu_old[i];
            length += prior_energy(n_x, P, o->z, o->x_minus);
        } else if (isfinite(distance))
            length += fmax(energy - 2 * product + distance, 0.0);
        const double decrement = sqrt(length);
        const int last = decrement <= s->tolerance;

        double alpha = 1, J_try, distance_try;
        for (;; alpha /= 2) {
            if (alpha < SHORTEST_STEP) { /* rounding, if the step is short; else a failure */
                *cost = J;
                return decrement <= FLOOR ? 0 : STATUS_SOLVER_FAILED;
            }
            distance_try = alpha == 1 ? energy
                                      : (1 - alpha) * (1 - alpha) * distance
                                            + 2 * alpha * (1 - alpha) * product
                                            + alpha * alpha * energy;
            roll_out(s, memory, alpha);
            J_try = measure(s, memory, o->x_try, o->w_try, row_scale_try, noise_scale_try)
                    + distance_try / 2;
            const double slack = ROUNDING * fmax(1.0, fabs(J));
            if (J_try <= J - SUFFICIENT * alpha * length + slack) break;
            if (last && isfinite(J_try)) break;
        }
        copy(x, o->x_try, count * n_x);
        copy(w, o->w_try, (count - 1) * m->n_w);
        copy(o->d, o->d_try, n_x);
        if (alpha == 1) {
            copy(o->mu_old, o->mu, n_x);
            mu_known = 1;
        } else if (mu_known)
            for (long long i = 0; i < n_x; i++)
                o->mu_old[i] = (1 - alpha) * o->mu_old[i] + alpha * o->mu[i];
        double *swap = row_scale;
        row_scale = row_scale_try, row_scale_try = swap;
        swap = noise_scale, noise_scale = noise_scale_try, noise_scale_try = swap;
        distance = distance_try;
        J = J_try;
        *cost = J;
        if (last) return 0;
        if (*iterations >= s->most_iterations) return STATUS_ITERATION_LIMIT;
        if (seconds() - began > s->most_seconds) return STATUS_TIME_LIMIT;
    }
}

/* Prior of the first stage that stays, given all readings before it: the dropped stage is
 * eliminated by one update and one prediction; see mhe/arrival_cost.py. `given` is the full
 * window; the new prior is written into `memory`. */
static void arrive(const Window *s, const double *given, double *memory)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const long long n_x = m->n_x;
    const double *mean = given + s->memory.prior_mean, *P = given + s->memory.prior_covariance;
    const double *x = given + s->memory.x, *w = given + s->memory.w;
    const double *y = given + s->memory.y, *row_scale = given + s->memory.present;
    const double *noise_scale = o->unit_noises;
    double *new_mean = memory + s->memory.prior_mean;
    double *new_P = memory + s->memory.prior_covariance;
    if (s->arrival == ARRIVAL_none) {
        copy(new_mean, mean, n_x);
        copy(new_P, P, n_x * n_x);
        return;
    }
    if (s->arrival == ARRIVAL_constant) {
        copy(new_mean, STAGE(given + s->memory.predicted, 1, n_x), n_x);
        copy(new_P, s->constant_covariance, n_x * n_x);
        return;
    }
    if (s->has_losses) {
        double part;
        const double *seen[] = {x, y, row_scale, s->huber};
        double *weighed[] = {o->row_scale, &part};
        s->measure(seen, weighed, 0, 0, 0);
        const double *shaken[] = {w, &s->huber_noise};
        double *shaking[] = {o->noise_scale, &part};
        s->shake(shaken, shaking, 0, 0, 0);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    int at_window = s->arrival == ARRIVAL_smoothed;
    if (s->arrival == ARRIVAL_filtered) {
        double off = 0;
        const double *judged[] = {mean, x, y, row_scale};
        double *results[] = {&off};
        s->misjudge(judged, results, 0, 0, 0);
        at_window = off > s->relinearisation_limit;
    }
    const double dt = interval(s, given, 0);
    double *updated[] = {o->x_plus, o->P_plus, 0, 0, 0, 0, 0, 0};
    update(m, mean, P, at_window ? x : mean, y, row_scale, updated);
    predict(m, o->x_plus, o->P_plus, at_window ? x : o->x_plus, at_window ? w : o->no_noise, &dt,
            noise_scale, new_mean, new_P, 0, 0);
}

/* Copy `given` to `memory`, without its oldest stage where the window is full, and append
 * an instant whose state is predicted. */
static void slide(const Window *s, const double *given, double *memory, double time,
                  const double *y)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const long long n_x = m->n_x, n_w = m->n_w, n_y = m->n_y, n_r = m->n_r;
    const long long before = (long long)given[at->count], drop = before == s->n_stages;
    const long long kept = before - drop;
    copy(memory + at->times, given + at->times + drop, kept);
    copy(memory + at->y, given + at->y + drop * n_y, kept * n_y);
    copy(memory + at->present, given + at->present + drop * n_r, kept * n_r);
    copy(memory + at->x, given + at->x + drop * n_x, kept * n_x);
    copy(memory + at->predicted, given + at->predicted + drop * n_x, kept * n_x);
    if (kept > 0) copy(memory + at->w, given + at->w + drop * n_w, (kept - 1) * n_w);
    if (drop)
        arrive(s, given, memory);
    else {
        copy(memory + at->prior_mean, given + at->prior_mean, n_x);
        copy(memory + at->prior_covariance, given + at->prior_covariance, n_x * n_x);
    }
    memory[at->count] = (double)(kept + 1);
    memory[at->times + kept] = time;
    mark_present(m, y, STAGE(memory + at->present, kept, n_r), STAGE(memory + at->y, kept, n_y));
    double *newest = STAGE(memory + at->x, kept, n_x);
    if (before == 0)
        copy(newest, memory + at->prior_mean, n_x);
    else {
        double *noise = STAGE(memory + at->w, before - 1 - drop, n_w);
        memset(noise, 0, (size_t)n_w * sizeof(double));
        move(s, STAGE(given + at->x, before - 1, n_x), noise,
             time - given[at->times + before - 1], newest);
    }
    copy(STAGE(memory + at->predicted, kept, n_x), newest, n_x);
}

static long long attempt(const Window *s, const double *given, double *memory, double time,
                         const double *y, double *result)
{
    const Model *m = &s->model;
    const Memory *at = &s->memory;
    const Work *o = &s->work;
    const long long n_x = m->n_x;
    slide(s, given, memory, time, y);
    double cost = NAN, iterations = 1;
    long long status = s->iterate ? converge(s, memory, &cost, &iterations) : one_pass(s, memory);
    const long long newest = (long long)memory[at->count] - 1;
    const double *mean = STAGE(memory + at->x, newest, n_x);
    const double *covariance = STAGE(o->P_plus, newest, n_x * n_x);
    if (!(all_finite(mean, n_x) && all_finite(covariance, n_x * n_x)))
        status |= STATUS_NOT_FINITE;
    copy(memory + at->newest_mean, mean, n_x);
    copy(memory + at->newest_covariance, covariance, n_x * n_x);
    const double *present = STAGE(memory + at->present, newest, m->n_r);
    status |= remarks(m, mean, covariance, y, present);
    report(m, &s->result, result, time, mean, covariance, o->v, o->S, present, status);
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    return status;
}

void window_step(void *self, const double *given, double *memory, double time, const double *y,
                 double *result)
{
    const Window *s = self;
    const Memory *at = &s->memory;
    const double start = seconds();
    const long long before = (long long)given[at->count];
    if (before > 0 && time < given[at->times + before - 1]) {
        copy(memory, given, at->size);
        report_late(&s->model, &s->result, result, given[at->times + before - 1],
                    given + at->newest_mean, given + at->newest_covariance);
    } else if (attempt(s, given, memory, time, y, result) & STATUS_NOT_FINITE) {
        /* A reading so far off that its square overflows would spoil the window for N
         * steps: the instant stays, its readings go. */
        long long status = attempt(s, given, memory, time, s->nothing, result);
        result[s->result.status] = (double)((status & ~STATUS_NO_READING) | STATUS_NOT_FINITE);
    }
    result[s->result.step_time_s] = seconds() - start;
}

/* Converge on the window in `memory`, from the trajectory that it holds. */
void window_solve(void *self, double *memory, double *result)
{
    const Window *s = self;
    const long long newest = (long long)memory[s->memory.count] - 1, n_x = s->model.n_x;
    double cost = NAN, iterations = 0;
    const double start = seconds();
    const long long status = converge(s, memory, &cost, &iterations);
    copy(result + s->result.mean, STAGE(memory + s->memory.x, newest, n_x), n_x);
    copy(result + s->result.covariance, STAGE(s->work.P_plus, newest, n_x * n_x), n_x * n_x);
    result[s->result.status] = (double)status;
    result[s->result.iterations] = iterations;
    result[s->result.cost] = cost;
    result[s->result.step_time_s] = seconds() - start;
}

int window_batch(Window *s, double *memory, double *other, long long n, const double *time,
                 const double *y, double *results)
{
    double *both[] = {memory, other};
    return batch(window_step, s, both, n, time, y, s->model.n_y, results, s->result.size);
}
