/* The stage in covariances, compiled for models of one size: behind pointers of the model. */

typedef void (*stage_predict)(const Model *, const real *, const real *, const real *, const real *,
                              const real *, const real *, const real *const *, real *const *);
typedef void (*stage_update)(const Model *, const real *, const real *, const real *, const real *,
                             const real *, real *const *);

static inline void predict(const Model *m, const real *d_plus, const real *P_plus,
                           const real *x_lin, const real *w_lin, const real *dt,
                           const real *noise_scale, const real *const *u, real *const *results)
{
    ((stage_predict)m->predict)(m, d_plus, P_plus, x_lin, w_lin, dt, noise_scale, u, results);
}

static inline void update(const Model *m, const real *d_minus, const real *P_minus,
                          const real *x_lin, const real *y, const real *present,
                          real *const *results)
{
    ((stage_update)m->update)(m, d_minus, P_minus, x_lin, y, present, results);
}
