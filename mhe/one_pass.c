/* Real-time iteration: one pass, and its full step. Behind mhe/active_set.c. */

/* The largest squared deviation of a stage from its linearisation point, in variances that its
 * readings up to then leave. */
static real moved_by(const Window *s, integer k, const real *d_s)
{
    const integer n_x = s->model.n_x;
    const real *P = SLOT(s->work.P_plus, k, n_x * n_x);
    real most = 0;
    for (integer i = 0; i < n_x; i++) {
        const real own = variance(&s->model, P, i), square = d_s[i] * d_s[i];
        if (square > most * own) most = square / own;
    }
    return most;
}

/* The linearised window's optimum becomes the trajectory. Stages whose estimate is near their
 * linearisation point keep it; see `slide`. */
static integer one_pass(const Window *s, real *memory, Solved *solved)
{
    const Model *m = &s->model;
    const Work *o = &s->work;
    const Memory *at = &s->memory;
    const integer count = (integer)memory[at->count], n_x = m->n_x;
    real *x = memory + at->x, *w = memory + at->w, *moved = memory + at->moved;
    const real *x_lin = memory + at->x_lin, *w_lin = memory + at->w_lin;
    const real *row_scale = memory + at->present, *noise_scale = o->unit_noises;
    real readings = 0;
    integer status = 0, held = 0;
    int changed = 0;
    const double began = now(s);
    if (s->has_losses) {
        readings = measure(s, memory, x, w, o->row_scale, o->noise_scale);
        row_scale = o->row_scale;
        noise_scale = o->noise_scale;
    }
    const real *deviation = memory + at->prior_deviation;
    const real squares = forward(s, memory, deviation, x_lin, w_lin, row_scale, noise_scale, 0);
    real length = backward(s, memory, w_lin, noise_scale, FREE, o->g);
    solved->passes = 1;
    if (!isfinite(readings) || !isfinite(squares) || !isfinite(length)) return STATUS_NOT_FINITE;
    if (s->n_c > 0) {
        constrain(s, memory, x_lin);
        status = meet_constraints(s, memory, w_lin, noise_scale, &length, o->g, &held, &changed);
    }
    for (integer k = 0; k < count; k++) {
        const real *d_s = STAGE(o->d_s, k, n_x);
        retract(m, STAGE(x_lin, k, n_x), d_s, STAGE(x, k, n_x));
        moved[k] = s->reuse > 0 ? moved_by(s, k, d_s) : INFINITY;
    }
    copy(w, o->g + n_x, (count - 1) * m->n_w);
    note_pass(s, count, began);
    solved->kkt = sqrt(length);
    if (s->n_c > 0)
        solved->kkt = fmax(solved->kkt, exceed(s, memory, x, o->violation, o->row_std));
    return status;
}
