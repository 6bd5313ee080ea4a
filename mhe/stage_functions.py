"""The symbolic functions of one stage that a pass back over a window needs.

With the forward stage's results (`estimation.kalman_stage`), from the newest stage to
the oldest, λ̂ = 0 at the newest (modified Bryson-Frazier form):

    retreat:  λ̂ = Fᵀ λ,   w_s = -D² Gᵀ λ
    smooth:   u = L⁻ᵀ (Wᵀ λ̂ + e),   δ_s = δ⁺ - P⁺ λ̂,   λ = λ̂ - Hᵀ u
    judge:    R u is the residual at δ_s as the stage's linearisation has it

A shift s of the mean behind a stage (a multiplier's impulse, mhe/compiled/smoother.c) goes on, and
comes back alone, through the same factors:

    propagate:  z = F s,   Δe = -L⁻¹ H z,   Δδ⁺ = z + W Δe
    absorb:     λ = λ̂ - Hᵀ L⁻ᵀ (Wᵀ λ̂ + Δe)

Below the oldest stage, x_s = x̄ ⊞ (-P̄ λ): the prior's multiplier is μ = -λ. No covariance
is ever inverted. On a manifold the prior's deviation d = x₀ ⊟ x̄ and that of the stage are
tangent vectors at two points: with J of `carry` the stage begins at N(-J d, J P̄ Jᵀ), and
μ = -Jᵀ λ, so that a pass is a Gauss-Newton step of the window's own cost.

References
----------
Bierman (1973), Fixed interval smoothing with discrete measurements, Int. J. Control 18(1).
Bell (1994), The iterated Kalman smoother as a Gauss-Newton method, SIAM J. Optim. 4(3).
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from estimation import in_order
from estimation.symbolic_stage import (
    difference_function,
    difference_jacobian,
    stacked_residual,
    step_symbols,
    unit_diagonal,
)
from mhe.constraint_rows import constrain_function
from mhe.loss import huber, huber_weight
from models.state_space import StateSpaceModel


def retreat_function(model: StateSpaceModel, predict: ca.Function) -> ca.Function:
    """Return (λ, F, G, diagonal of D) → (λ̂, w_s); F and G as `predict` leaves them."""
    lam, noise_scale = ca.SX.sym("lam", model.n_x), ca.SX.sym("noise_scale", model.n_w)
    F = ca.SX.sym("F", predict.sparsity_out("F"))
    G = ca.SX.sym("G", predict.sparsity_out("G"))
    lam_hat, w_s = (
        in_order.product(F.T, lam, unit=unit_diagonal(model)),
        -(noise_scale * noise_scale * (G.T @ lam)),
    )
    return _function(
        "retreat",
        {"lam": lam, "F": F, "G": G, "noise_scale": noise_scale},
        lam_hat=lam_hat,
        w_s=w_s,
    )


def smooth_function(model: StateSpaceModel, update: ca.Function) -> ca.Function:
    """Return (δ⁺, P⁺ λ̂, λ̂, W, e, L, H) → (δ_s, λ, ‖H δ_s / σ‖², σ u)."""
    n_x, n_r = model.n_x, model.n_r
    d_plus, spread = ca.SX.sym("d_plus", n_x), ca.SX.sym("spread", n_x)
    lam_hat, W, e = ca.SX.sym("lam_hat", n_x), ca.SX.sym("W", n_x, n_r), ca.SX.sym("e", n_r)
    L = ca.SX.sym("L", update.sparsity_out("L"))
    H = ca.SX.sym("H", update.sparsity_out("H"))
    u, lam = _back(L, W, e, H, lam_hat)
    d_s = d_plus - spread
    length = ca.sumsqr(H @ d_s / model.noise_std)
    expected = ca.DM(model.noise_std) * u
    arguments = {
        "d_plus": d_plus,
        "spread": spread,
        "lam_hat": lam_hat,
        "W": W,
        "e": e,
        "L": L,
        "H": H,
    }
    return _function("smooth", arguments, d_s=d_s, lam=lam, length=length, expected=expected)


def _back(L: ca.SX, W: ca.SX, e: ca.SX, H: ca.SX, lam_hat: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return u = L⁻ᵀ (Wᵀ λ̂ + e) and λ = λ̂ - Hᵀ u, in the order of mhe/compiled/smoother.c."""
    n_r, lam = H.size1(), ca.vertsplit(lam_hat)
    u = [in_order.dot(W[:, r], lam_hat) + e[r] for r in range(n_r)]
    for r in reversed(range(n_r)):
        u[r] = u[r] / L[r, r]
        for q in range(r):
            u[q] = u[q] - L[r, q] * u[r]
        for k in H[r, :].sparsity().get_col():
            lam[k] = lam[k] - H[r, k] * u[r]
    return ca.vertcat(ca.SX(0, 1), *u), ca.vertcat(*lam)


def judge_function(model: StateSpaceModel) -> ca.Function:
    """Return (x, y, present, expected) → by how many σ readings are off what a stage expects.

    ``max |D r(x) / σ - expected|`` over the rows present, of a stage's ``smooth`` and its estimate
    x; D are the rows' scales, ones without a loss.
    """
    x, y = ca.SX.sym("x", model.n_x), ca.SX.sym("y", model.n_row)
    present = ca.SX.sym("present", model.n_r)
    expected = ca.SX.sym("expected", model.n_r)
    residual = stacked_residual(model, y, x) / model.noise_std
    off = ca.fabs(present * residual - ca.sign(present) * expected)
    arguments = {"x": x, "y": y, "present": present, "expected": expected}
    return _function("judge", arguments, off=ca.mmax(ca.vertcat(0, off)))


def spread_function(model: StateSpaceModel) -> ca.Function:
    """Return (P, v) → P v."""
    P, v = ca.SX.sym("P", model.n_x, model.n_x), ca.SX.sym("v", model.n_x)
    return _function("spread", {"P": P, "v": v}, product=P @ v)


def propagate_function(
    model: StateSpaceModel, predict: ca.Function, update: ca.Function
) -> ca.Function:
    """Return (s, F, W, L, H) → (Δe, Δδ⁺)."""
    n_x, n_r = model.n_x, model.n_r
    shift, W = ca.SX.sym("shift", n_x), ca.SX.sym("W", n_x, n_r)
    F = ca.SX.sym("F", predict.sparsity_out("F"))
    L, H = ca.SX.sym("L", update.sparsity_out("L")), ca.SX.sym("H", update.sparsity_out("H"))
    z = in_order.product(F, shift, unit=unit_diagonal(model))
    e = -ca.solve(L, H @ z)
    arguments = {"shift": shift, "F": F, "W": W, "L": L, "H": H}
    return _function("propagate", arguments, e=e, d_plus=z + W @ e)


def absorb_function(model: StateSpaceModel, update: ca.Function) -> ca.Function:
    """Return (λ̂, W, Δe, L, H) → λ."""
    n_x, n_r = model.n_x, model.n_r
    lam_hat, W, e = ca.SX.sym("lam_hat", n_x), ca.SX.sym("W", n_x, n_r), ca.SX.sym("e", n_r)
    L, H = ca.SX.sym("L", update.sparsity_out("L")), ca.SX.sym("H", update.sparsity_out("H"))
    _, lam = _back(L, W, e, H, lam_hat)
    return _function("absorb", {"lam_hat": lam_hat, "W": W, "e": e, "L": L, "H": H}, lam=lam)


def measure_function(model: StateSpaceModel) -> ca.Function:
    """Return (x, y, present, thresholds (n_sensors,)) → (row scale (n_r,), cost)."""
    x, y = ca.SX.sym("x", model.n_x), ca.SX.sym("y", model.n_row)
    present = ca.SX.sym("present", model.n_r)
    threshold = ca.SX.sym("threshold", len(model.sensors))
    r = present * stacked_residual(model, y, x) / model.noise_std
    scales, cost, row = [ca.SX(0, 1)], ca.SX(0), 0
    for i, sensor in enumerate(model.sensors):
        rows = slice(row, row + sensor.n_r)
        squared = ca.sumsqr(r[rows])
        scales.append(present[rows] * ca.sqrt(huber_weight(squared, threshold[i])))
        cost += huber(squared, threshold[i])
        row += sensor.n_r
    arguments = {"x": x, "y": y, "present": present, "threshold": threshold}
    return _function("measure", arguments, row_scale=ca.vertcat(*scales), cost=cost)


def shake_function(model: StateSpaceModel) -> ca.Function:
    """Return (w, threshold) → (diagonal of D (n_w,), cost)."""
    w, threshold = ca.SX.sym("w", model.n_w), ca.SX.sym("threshold")
    parts = [w[i] ** 2 for i in range(model.n_w)]
    scale = [1 / ca.sqrt(huber_weight(part, threshold)) for part in parts]
    cost = sum((huber(part, threshold) for part in parts), ca.SX(0))
    arguments = {"w": w, "threshold": threshold}
    return _function("shake", arguments, noise_scale=ca.vertcat(ca.SX(0, 1), *scale), cost=cost)


@lru_cache(maxsize=16)
def carry_function(model: StateSpaceModel) -> ca.Function | None:
    """Return (x̄, d, x = x̄ ⊞ d) → J (n_x, n_x) = ∂((x̄ ⊞ (d + ε)) ⊟ x)/∂ε at ε = 0.

    A prior of d, N(0, P̄), is N(-J d, J P̄ Jᵀ) of the deviation from x. None where states add:
    there J is the identity.
    """
    n_x = model.n_x
    mean, d, x = ca.SX.sym("mean", n_x), ca.SX.sym("d", n_x), ca.SX.sym("x", n_x)
    J = ca.sparsify(difference_jacobian(model, x) @ ca.jacobian(model.retract(mean, d), d))
    if ca.sparsify(J - ca.SX.eye(n_x)).nnz() == 0:
        return None
    return _function("carry", {"mean": mean, "d": d, "x": x}, J=J)


@lru_cache(maxsize=16)
def pass_functions(
    model: StateSpaceModel, predict: ca.Function, update: ca.Function
) -> tuple[ca.Function, ...]:
    """Return what the pass back is made of, where C's loops (mhe/compiled/smoother.c) are not."""
    return (
        retreat_function(model, predict),
        smooth_function(model, update),
        propagate_function(model, predict, update),
        absorb_function(model, update),
        spread_function(model),
    )


@lru_cache(maxsize=16)
def window_functions(model: StateSpaceModel) -> tuple[ca.Function, ...]:
    """Return what a window needs of its model beside its stage."""
    x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
    inputs = step_symbols(model)
    reached = model.f(x, w, dt, *inputs.values())
    reached = model.retract(reached, ca.SX.zeros(model.n_x))  # angles within a turn
    return (
        constrain_function(model),
        measure_function(model),
        shake_function(model),
        judge_function(model),
        _function("move", {"x": x, "w": w, "dt": dt, **inputs}, reached=reached),
        difference_function(model),
    )


def _function(name: str, arguments: dict[str, ca.SX], **results: ca.SX) -> ca.Function:
    return ca.Function(
        name,
        list(arguments.values()),
        [ca.densify(value) for value in results.values()],
        list(arguments),
        list(results),
        {"cse": True},
    )
