"""What a choice of sensors can see: the observability Gramian along a motion.

Noise-free transitions Φ_k = F_{k-1} … F_0 carry a small change of the first
state to every reading:

    O = [R^-½ H_0; R^-½ H_1 Φ_1; …] D,      Gramian W = Oᵀ O

with D the prior's standard deviations: in a direction with singular value s the
readings, at their noise, say s times as much as was known before (in standard
deviations). Where s is zero, up to rounding, no reading shows a change: the
direction is unobservable. Unobservable directions are returned in the model's
own states, or in motions where it names them (a free pen's "turning about the vertical"), each
with a leading one that no other has (a pivoted echelon form), so that they can be read:
"azimuth alone", "azimuth with tip acceleration".

Symmetries of a model (`estimation.symmetry`: a pen's heading) show only along a
motion that obeys it exactly; along any other the linearised readings seem to tell
apart what they cannot. A `Verdict` therefore takes the Gramian along short
motions that start in true states and run freely, `free_motion`, and asks
`estimation.information_bound` what process noise leaves of weak directions. What people read
(`estimation.outputs`) counts as observable when neither leaves `OBSERVABLE_FRACTION` of the
prior's standard deviation.

A verdict is the model's. White jerk on Euler angles (the pen of [Pen], which cannot spin) makes a
gyroscope alone show tilt in fast motion: true of that pen, and of no other.

References
----------
Chen (1999), Linear System Theory and Design, section 6.3 (time-varying).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import orth, qr, solve_triangular

from estimation.derivatives import Derivatives
from estimation.information_bound import OBSERVABLE_FRACTION, InformationBound, information_bound
from estimation.outputs import output_jacobian, outputs_of
from estimation.recording import Measurement
from estimation.symmetry import direction, holds
from models.arrays import Array
from models.state_space import StateSpaceModel

ROUNDING = 1e-6
"""Singular values below it are zero up to rounding; the weakest true ones are near 1e-2."""

FREE_S, FREE_STARTS = 0.5, 5
"""Duration and number of the free motions of a verdict."""

SYMMETRY_STATES = 5
"""About how many states a symmetry is tried at."""

NEGLIGIBLE = 1e-6
"""Part of a direction below which a state does not take part in it (rounding)."""


@dataclass(frozen=True, eq=False)
class UnobservableDirection:
    """A change of the state that the readings do not show.

    Parameters
    ----------
    changes : state or motion → change in its unit; the first is the leading one
    """

    changes: dict[str, float]
    units: dict[str, str]

    @property
    def words(self) -> str:
        """Return e.g. ``azimuth_rad alone``, or what else has to change with it."""
        (leading, amount), *others = self.changes.items()
        if not others:
            return f"{leading} alone"
        rest = ", ".join(f"{name} by {change / amount:.3g}" for name, change in others)
        return f"{leading} by 1 with {rest}"


@dataclass(frozen=True, eq=False)
class Observability:
    """What the readings of a motion say about its first state.

    Parameters
    ----------
    state_names : (n_x,) what may change: states, or motions where the model names them
    prior_std : (n_x,) what was known of these changes
    singular_values : (n_x,) of O, descending
    names : (n_o,) what people read
    gradients : (n_o, n_x) of it, by the changes in prior units
    directions : of the unobservable subspace, a basis that is easy to read
    unobservable : (n_x, n) orthonormal basis of the same subspace in prior units
    """

    state_names: tuple[str, ...]
    prior_std: Array
    singular_values: Array
    names: tuple[str, ...]
    gradients: Array
    directions: tuple[UnobservableDirection, ...]
    unobservable: Array

    @property
    def rank(self) -> int:
        """Number of observable directions."""
        return len(self.state_names) - self.unobservable.shape[1]

    @property
    def unseen_fraction(self) -> Array:
        """(n_o,) part of each output's prior deviation that no reading can remove."""
        unseen: Array = np.linalg.norm(self.gradients @ self.unobservable, axis=1)
        return unseen / np.linalg.norm(self.gradients, axis=1)


@dataclass(frozen=True, eq=False)
class Verdict:
    """Gramian and information bound of one configuration along one motion."""

    observability: Observability
    bound: InformationBound

    @property
    def unseen_fraction(self) -> Array:
        """(n_o,) the larger of both parts of the prior's standard deviation that stay."""
        left = self.bound.std[-1] / self.bound.prior_std
        return np.maximum(left, self.observability.unseen_fraction)

    def sees(self, name: str) -> bool:
        """Whether the readings say clearly more about an output than the prior did."""
        index = self.bound.names.index(name)
        return bool(self.unseen_fraction[index] < OBSERVABLE_FRACTION)


def observability_matrix(
    model: StateSpaceModel,
    measurements: Sequence[Measurement],
    states: Array,
    *,
    derivatives: Derivatives | None = None,
) -> Array:
    """Return O (n_rows, n_x) along known states, scaled as in the module's equation.

    Parameters
    ----------
    measurements : their times, and which rows are present; the values only place
        where curved residuals are linearised
    states : (n, n_x) the true states, one per measurement
    derivatives : of the model, where they are built already
    """
    at, D = derivatives or Derivatives(model), model.prior.std
    rows, Phi = [], np.eye(model.n_x)
    for k, (measurement, x) in enumerate(zip(measurements, states, strict=True)):
        if k:
            dt = measurement.time_s - measurements[k - 1].time_s
            inputs = model.step_inputs(measurements[k - 1].y, measurement.y)
            Phi = at.of_step(states[k - 1], dt, inputs=inputs)[0] @ Phi
        H = at.of_readings(x, measurement.y)
        rows.append((H / model.noise_std[:, None]) @ Phi * D)
    return np.vstack(rows)


def observability(
    model: StateSpaceModel,
    measurements: Sequence[Measurement],
    states: Array,
    *,
    derivatives: Derivatives | None = None,
) -> Observability:
    """Return what a motion's readings say about its first state; see `observability_matrix`."""
    whole = _whole_changes(model, states[0])
    scaled = observability_matrix(model, measurements, states, derivatives=derivatives)
    scaled = scaled / model.prior.std @ whole.to_tangent
    _, s, Vt = np.linalg.svd(scaled, full_matrices=len(scaled) < model.n_x)
    singular = np.zeros(model.n_x)
    singular[: len(s)] = s
    unobservable = _joined(
        Vt[singular < ROUNDING].T,
        _symmetric(model, measurements, states, whole),
        scaled[np.tile(~model.measured_rows, len(states))],
    )
    return Observability(
        whole.names,
        whole.std,
        singular,
        outputs_of(model).names,
        output_jacobian(model)(states[0]).full() @ whole.to_tangent,
        _directions(whole, unobservable),
        unobservable,
    )


@dataclass(frozen=True, eq=False)
class _WholeChanges:
    """Changes of a state as people name them, in units of what was known of them before.

    Parameters
    ----------
    names, units, std : (n_x,)
    of_tangent, to_tangent : (n_x, n_x) from a tangent vector to them, and back
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    std: Array
    of_tangent: Array
    to_tangent: Array


def _whole_changes(model: StateSpaceModel, x: Array) -> _WholeChanges:
    """Return those of a model's `tangent` names at a state, or of its states."""
    names, units, T = model.state_names, model.state_units, np.eye(model.n_x)
    if model.tangent is not None:
        names, units, T = model.tangent.names, model.tangent.units, model.tangent.function(x).full()
    std = np.sqrt(np.diag(T @ model.prior.covariance @ T.T)).astype(float)
    return _WholeChanges(names, units, std, T / std[:, None], np.linalg.inv(T) * std)


def _symmetric(
    model: StateSpaceModel,
    measurements: Sequence[Measurement],
    states: Array,
    whole: _WholeChanges,
) -> Array:
    """Return the directions (n_x, n) of symmetries that hold, at the first state."""
    dt = measurements[1].time_s - measurements[0].time_s if len(measurements) > 1 else 0.0
    found = [
        whole.of_tangent @ direction(model, symmetry, states[0])
        for symmetry in model.symmetries
        if holds(model, symmetry, states[:: max(1, len(states) // SYMMETRY_STATES)], dt)
    ]
    return np.array(found).reshape(len(found), model.n_x).T


def _joined(basis: Array, symmetric: Array, constant_rows: Array) -> Array:
    """Return an orthonormal basis (n_x, n) that also spans the symmetric directions.

    A constant reading places what it reads: a symmetry adds nothing where all that it
    moves beyond the basis is this (a tip at rest beside the centre of its area).
    """
    if not symmetric.shape[1]:
        return basis
    rest = symmetric / np.linalg.norm(symmetric, axis=0)
    rest = rest - basis @ (basis.T @ rest)
    placed = orth(constant_rows.T)
    not_placed = rest - placed @ (placed.T @ rest)
    rest = rest[:, np.linalg.norm(not_placed, axis=0) > NEGLIGIBLE]
    U, s, _ = np.linalg.svd(rest, full_matrices=False)
    return np.hstack([basis, U[:, s > NEGLIGIBLE]])


def free_motion(
    model: StateSpaceModel,
    x: Array,
    *,
    duration_s: float = FREE_S,
    steps: int = 50,
    inputs: Array | None = None,
) -> tuple[list[Measurement], Array]:
    """Return the readings without noise and the states (n, n_x) of a motion that runs freely.

    x_{k+1} = f(x_k, 0, Δt): nothing but the model drives it. Every sensor reads at every step,
    but nothing says that the body rests. Inputs (n_u,) stay what they are, zero by default. Steps
    of a model of whole intervals are one at least.
    """
    states, no_noise, dt = [x], np.zeros(model.n_w), duration_s / steps
    if model.interval_s is not None:
        dt = model.interval_s * max(1, round(dt / model.interval_s))
    u = np.zeros(model.n_u) if inputs is None else inputs
    held = (u, u) if model.n_u else ()
    for _ in range(steps):
        states.append(model.f(states[-1], no_noise, dt, *held).full().ravel())
    named = dict(zip(model.input_names, u, strict=True))
    # One call for all instants: CasADi takes a column for each.
    readings = {
        sensor.name: sensor.h(np.array(states).T, *sensor.inputs_of(u)).full().T
        for sensor in model.sensors
        if sensor.rest is None
    }
    rows = [
        model.stack({name: of_all[k] for name, of_all in readings.items()}, named)
        for k in range(len(states))
    ]
    times = dt * np.arange(steps + 1)
    return [Measurement(t, y) for t, y in zip(times, rows, strict=True)], np.array(states)


def verdict(model: StateSpaceModel, measurements: Sequence[Measurement], states: Array) -> Verdict:
    """Return Gramian and information bound along known states.

    The Gramian is the one of largest rank of `FREE_STARTS` free motions from states spread
    over the known ones: the part of the motion that shows most.
    """
    starts = start_rows(len(states))
    inputs = [measurements[i].y[model.n_y :] for i in starts]
    bound = information_bound(model, measurements, states)
    return verdict_from(model, states[starts], inputs, bound)


def start_rows(n: int) -> NDArray[np.intp]:
    """Return at which of n known states the free motions of a verdict start."""
    return np.linspace(0, n - 1, FREE_STARTS).astype(int)


def verdict_from(
    model: StateSpaceModel, starts: Array, inputs: Sequence[Array], bound: InformationBound
) -> Verdict:
    """Return the verdict of free motions from some true states (m, n_x), and of a bound.

    Parameters
    ----------
    inputs : m of (n_u,), known at the starts
    """
    at = Derivatives(model)
    motions = [free_motion(model, x, inputs=u) for x, u in zip(starts, inputs, strict=True)]
    candidates = [observability(model, *motion, derivatives=at) for motion in motions]
    return Verdict(max(candidates, key=lambda found: found.rank), bound)


def _directions(whole: _WholeChanges, basis: Array) -> tuple[UnobservableDirection, ...]:
    """Turn an orthonormal basis (n_x, n) of whole changes into readable directions.

    Column-pivoted QR of the transpose picks the n changes that best tell the
    directions apart; solving for them leaves each in one direction only.
    """
    n_x, n = basis.shape
    if n == 0:
        return ()
    _, R, order = qr(basis.T, mode="economic", pivoting=True)
    echelon = np.zeros((n, n_x))
    echelon[:, order] = solve_triangular(R[:, :n], R)
    units = dict(zip(whole.names, whole.units, strict=True))
    found = []
    for row, leading in sorted(zip(echelon, order[:n], strict=True), key=lambda pair: pair[1]):
        members = np.flatnonzero(np.abs(row) > NEGLIGIBLE)
        ordered = [leading, *(i for i in members if i != leading)]
        changes = {whole.names[i]: float(row[i] * whole.std[i]) for i in ordered}
        found.append(UnobservableDirection(changes, {name: units[name] for name in changes}))
    return tuple(found)
