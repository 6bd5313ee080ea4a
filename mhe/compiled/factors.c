/* The forward pass: Kalman stages over the window. Behind mhe/compiled/trajectory.c.
 *
 * Its factors stay in the workspace. Where the next window's oldest stages have the same
 * readings, linearisation points and prior, to the last bit, their factors are those of
 * the last pass and are not made again: what a pass says is the same either way. A slide moves no
 * factors: stage k stands in slot (oldest slot + k), around a ring. Of the covariances P⁻ only the
 * oldest stage's, the prior's, is kept: `leave` says how it goes on to the next. */

#define OLDEST_SLOT 0
#define MADE 1

static inline integer slot(const Window *s, integer k)
{
    const integer at = s->work.ring[OLDEST_SLOT] + k;
    return at < s->n_stages ? at : at - s->n_stages;
}

#define SLOT(array, k, width) ((array) + slot(s, k) * (width))

static inline int same(const real *a, const real *b, integer n)
{
    return memcmp(a, b, (size_t)n * sizeof(real)) == 0;
}

/* Whether the factors of the oldest stage are made of its prior. */
static int has_prior(const Window *s, const real *deviation, const real *P)
{
    const Work *o = &s->work;
    const integer n_x = s->model.n_x;
    return o->ring[MADE] > 0 && same(SLOT(o->d_minus, 0, n_x), deviation, n_x)
           && same(o->P_first, P, s->model.n_P);
}

/* Whether the factors of a stage are made of its time, point, readings and their scales. */
static int has_readings(const Window *s, integer k, const real *memory, const real *x,
                        const real *row_scale)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_row = m->n_row, n_r = m->n_r;
    return *SLOT(o->at_time, k, 1) == memory[s->memory.times + k]
           && same(SLOT(o->at_x, k, n_x), STAGE(x, k, n_x), n_x)
           && same(SLOT(o->at_y, k, n_row), STAGE(memory + s->memory.y, k, n_row), n_row)
           && same(SLOT(o->at_rows, k, n_r), STAGE(row_scale, k, n_r), n_r);
}

/* Whether the factors of a stage are made of the noises that lead to it. */
static int has_noises(const Window *s, integer k, const real *w, const real *noise_scale)
{
    const Work *o = &s->work;
    const integer n_w = s->model.n_w;
    return same(SLOT(o->at_w, k, n_w), STAGE(w, k - 1, n_w), n_w)
           && same(SLOT(o->at_noises, k, n_w), STAGE(noise_scale, k - 1, n_w), n_w);
}

/* How many stages, from the oldest, have factors of what they are made of now. */
static integer unchanged(const Window *s, const real *memory, const real *deviation,
                         const real *x, const real *w, const real *row_scale,
                         const real *noise_scale)
{
    const integer count = (integer)memory[s->memory.count], made = s->work.ring[MADE];
    integer k = 0;
    if (!has_prior(s, deviation, memory + s->memory.prior_covariance)) return 0;
    while (k < count && k < made && has_readings(s, k, memory, x, row_scale)
           && (k == 0 || has_noises(s, k, w, noise_scale)))
        k++;
    return k;
}

/* Whether the factors of the oldest stage of the window `given` are there, rows scaled like this. */
static int has_oldest(const Window *s, const real *given, const real *row_scale)
{
    const Memory *at = &s->memory;
    return has_prior(s, given + at->prior_deviation, given + at->prior_covariance)
           && has_readings(s, 0, given, given + at->x_lin, row_scale);
}

/* The oldest stage, whose factors are there, leaves, eliminated as they were made: those behind it
 * follow from the new prior's covariance P as they are, where they were the factors of the window
 * `given`. */
static void leave(const Window *s, const real *given, const real *P)
{
    const Work *o = &s->work;
    if (o->ring[MADE] < 2 || *SLOT(o->at_time, 1, 1) != given[s->memory.times + 1]
        || !has_noises(s, 1, given + s->memory.w_lin, o->unit_noises))
        return;
    copy(o->P_first, P, s->model.n_P);
    o->ring[OLDEST_SLOT] = slot(s, 1);
    o->ring[MADE]--;
}

#if CONVERGES
/* Condition a stage on its rows in the active set, g + C' δ = 0: readings without noise.
 * Returns whether that is possible. */
static int condition(const Window *s, integer k)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer n_x = m->n_x, n_c = s->n_c;
    for (integer i = k * n_c; i < (k + 1) * n_c; i++) {
        if (o->is_held[i] == 0) continue;
        const real *C = STAGE(o->row_C, i, n_x);
        real *d_plus = SLOT(o->d_plus, k, n_x), *W = STAGE(o->row_PC, i, n_x);
        spread(m, SLOT(o->P_plus, k, s->model.n_P), C, W);
        const real own = dot(C, W, n_x);
        if (!(own > 0)) return 0;
        o->row_std_held[i] = sqrt(own);
        for (integer a = 0; a < n_x; a++) W[a] /= o->row_std_held[i];
        o->row_e[i] = -(o->row_g[i] + dot(C, d_plus, n_x)) / o->row_std_held[i];
        for (integer a = 0; a < n_x; a++) d_plus[a] += W[a] * o->row_e[i];
        take_from(m, SLOT(o->P_plus, k, s->model.n_P), C, W);
    }
    return 1;
}
#endif

#if CONVERGES
/* The oldest stage's deviation and covariance in the tangent space at its own point: J d⁻, J P Jᵀ. */
static void carry_prior(const Window *s, const real *memory, const real *deviation, const real *x,
                        real *d_minus, real *P_minus)
{
    const Work *o = &s->work;
    const real *P = memory + s->memory.prior_covariance;
    const integer n = s->model.n_x, stride = s->model.stride;
    for (integer i = 0; i < n; i++) o->d_carried[i] = -deviation[i];
    const real *arguments[] = {memory + s->memory.prior_mean, o->d_carried, x};
    real *results[] = {o->J}; /* by columns */
    call(&s->model, &s->carry, arguments, results);
    memset(d_minus, 0, (size_t)n * sizeof(real));
    for (integer j = 0; j < n; j++)
        for (integer i = 0; i < n; i++) d_minus[i] += o->J[i + n * j] * deviation[j];
    if (is_root(P)) {
        real *array = s->model.array;
        memset(array, 0, (size_t)(n * n) * sizeof(real));
        for (integer j = 0; j < n; j++)
            for (integer c = 0; c <= j; c++)
                for (integer i = 0; i < n; i++) array[c * n + i] += o->J[i + n * j] * P[j * stride + c];
        triangular(&s->model, n, s->model.root);
        keep_root(&s->model, s->model.root, P_minus);
        return;
    }
    memset(o->JP, 0, (size_t)(n * n) * sizeof(real));
    memset(P_minus, 0, (size_t)s->model.n_P * sizeof(real));
    for (integer j = 0; j < n; j++)
        for (integer i = 0; i < n; i++) {
            const real entry = o->J[i + n * j];
            if (entry == 0) continue;
            for (integer k = 0; k < n; k++) o->JP[i * n + k] += entry * P[j * stride + k];
        }
    for (integer j = 0; j < n; j++)
        for (integer i = 0; i < n; i++) {
            const real entry = o->J[i + n * j];
            if (entry == 0) continue;
            for (integer k = 0; k < n; k++) P_minus[k * stride + i] += o->JP[k * n + j] * entry;
        }
}

/* The prior's multiplier μ = -Jᵀ λ, in place of -λ. */
static void carry_back(const Window *s, real *mu)
{
    const Work *o = &s->work;
    const integer n = s->model.n_x;
    for (integer j = 0; j < n; j++) {
        o->d_carried[j] = 0;
        for (integer i = 0; i < n; i++) o->d_carried[j] += o->J[i + n * j] * mu[i];
    }
    copy(mu, o->d_carried, n);
}
#endif

/* Kalman stages linearised at (x, w), from the prior's deviation δ⁻ at the first stage;
 * conditioned on the rows of the active set where these are `held`. The stage of the measurement
 * that the step was given, `told`, tells v and S. Returns the sum of squared
 * whitened innovations of the stages that it made, NAN where rows cannot be held. */
static real forward(const Window *s, const real *memory, const real *deviation, const real *x,
                    const real *w, const real *row_scale, const real *noise_scale, int held)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const integer count = (integer)memory[s->memory.count], n_x = m->n_x, n_r = m->n_r;
    const integer n_w = m->n_w;
    const real *y = memory + s->memory.y;
    const integer known = unchanged(s, memory, deviation, x, w, row_scale, noise_scale);
    const integer told = o->told[0], first = known < told ? known : told;
    o->ring[MADE] = count;
    o->reused[0] = (real)first;
    for (integer k = first; k < count; k++) {
        real *d_minus = SLOT(o->d_minus, k, n_x), *P_minus = k == 0 ? o->P_first : o->P_minus;
        if (k == 0) {
            copy(d_minus, deviation, n_x);
            copy(P_minus, memory + s->memory.prior_covariance, m->n_P);
#if CONVERGES
            if (s->iterate && s->carry.evaluate) carry_prior(s, memory, deviation, x, d_minus, P_minus);
#endif
        } else {
            const real dt = interval(s, memory, k - 1);
            const real *u[] = {inputs_at(s, memory, k - 1), inputs_at(s, memory, k)};
            real *predicted[] = {o->reached, d_minus, P_minus, SLOT(o->F, k - 1, s->nnz_F),
                                 SLOT(o->G, k - 1, s->nnz_G)};
            predict(m, SLOT(o->d_plus, k - 1, n_x), SLOT(o->P_plus, k - 1, s->model.n_P),
                    STAGE(x, k - 1, n_x), STAGE(w, k - 1, n_w), &dt,
                    STAGE(noise_scale, k - 1, n_w), u, predicted);
            difference(s, o->reached, STAGE(x, k, n_x), o->defect);
            for (integer i = 0; i < n_x; i++) d_minus[i] += o->defect[i];
            copy(SLOT(o->at_w, k, n_w), STAGE(w, k - 1, n_w), n_w);
            copy(SLOT(o->at_noises, k, n_w), STAGE(noise_scale, k - 1, n_w), n_w);
        }
        *SLOT(o->at_time, k, 1) = memory[s->memory.times + k];
        copy(SLOT(o->at_x, k, n_x), STAGE(x, k, n_x), n_x);
        copy(SLOT(o->at_y, k, m->n_row), STAGE(y, k, m->n_row), m->n_row);
        copy(SLOT(o->at_rows, k, n_r), STAGE(row_scale, k, n_r), n_r);
        const int tells = k == told;
        real *updated[] = {SLOT(o->d_plus, k, n_x),  SLOT(o->P_plus, k, s->model.n_P),
                           tells ? o->v : 0,         tells ? o->S : 0,
                           SLOT(o->W, k, s->model.stride * n_r), SLOT(o->e, k, n_r),
                           SLOT(o->H, k, s->nnz_H),  SLOT(o->L, k, s->nnz_L)};
        update(m, d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_row),
               STAGE(row_scale, k, n_r), updated);
#if CONVERGES
        if (held && !condition(s, k)) {
            o->ring[MADE] = 0;
            return NAN;
        }
#endif
        if (LOSSES && tells && s->has_losses
            && !same(STAGE(row_scale, k, n_r), STAGE(memory + s->memory.present, k, n_r), n_r)) {
            /* told is the innovation itself, not its weighed share */
            real *unweighed[] = {0, 0, o->v, o->S, 0, 0, 0, 0};
            update(m, d_minus, P_minus, STAGE(x, k, n_x), STAGE(y, k, m->n_row),
                   STAGE(memory + s->memory.present, k, n_r), unweighed);
        }
    }
    real squares = 0;
    for (integer k = first; k < count; k++)
        squares += dot(SLOT(o->e, k, n_r), SLOT(o->e, k, n_r), n_r);
    if (held || !isfinite(squares)) o->ring[MADE] = 0; /* factors of another problem, or of none */
    return squares;
}
