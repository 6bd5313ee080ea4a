/* The Kalman stage in square roots alone: an array named P_ holds S, its diagonal not negative.
 * Behind estimation/root_stage.c. */

static void predict(const Model *m, const real *d_plus, const real *S_plus, const real *x_lin,
                    const real *w_lin, const real *dt, const real *noise_scale,
                    const real *const *u, real *const *results)
{
    real *F = results[3] ? results[3] : m->F, *G = results[4] ? results[4] : m->G;
    step_at(m, d_plus, x_lin, w_lin, dt, noise_scale, u, results[0], results[1], F, G, 0);
    if (results[2]) predict_root(m, F, G, S_plus, noise_scale, results[2]);
}

static void update(const Model *m, const real *d_minus, const real *S_minus, const real *x_lin,
                   const real *y, const real *present, real *const *results)
{
    real *v = results[2] ? results[2] : m->v;
    real *e = results[5] ? results[5] : m->e, *H = results[6] ? results[6] : m->H;
    real *L = results[7] ? results[7] : m->L;
    read_at(m, d_minus, x_lin, y, present, v, H);
    if (results[0]) copy(results[0], d_minus, N_X);
    update_root(m, H, v, S_minus, present, results[0], results[1], results[4], e, L);
    if (results[3]) innovation_covariance(m, present, L, results[3]);
}

static inline void spread(const Model *m, const real *S, const real *v, real *product)
{
    spread_root(m, S, v, product);
}

static inline void add_covariance(const Model *m, real *S, real by, const real *Q)
{
    add_to_root(m, S, by, Q, S);
}

static inline real variance(const Model *m, const real *S, integer i)
{
    return variance_root(m, S, i);
}

static void covariance_of(const Model *m, const real *S, real *covariance)
{
    covariance_of_root(m, S, covariance);
}
