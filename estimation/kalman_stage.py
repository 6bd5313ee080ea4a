"""The Kalman stage: predict and update, symbolically, at any linearisation point.

The stage that the EKF and every pass of an optimisation-based estimator share. States are
x = x̃ ⊞ δ around a trajectory (x̃, w̃) that may differ from the filter's own mean:

    predict:  δ⁻ = F δ⁺ - G w̃ around f(x̃, w̃),   P⁻ = F P⁺ Fᵀ + G D² Gᵀ
    update:   v = residual(y, x̃) - H δ⁻,   L Lᵀ = H P⁻ Hᵀ + R
              W = P⁻ Hᵀ L⁻ᵀ,   e = L⁻¹ v
              δ⁺ = δ⁻ + W e,   P⁺ = P⁻ - W Wᵀ

with ⊞ the model's ``retract``, ⊟ its ``difference``, F, G and H derivatives along the
tangent space at (x̃, w̃). A missing row has its row of v and H zero; a loss other than
least squares scales rows of v and H, and the noises by D. Deviations, not means, are
carried from stage to stage: an angle may deviate by more than a turn before it wraps, and
the pass stays the linear solve that it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from estimation.chosen import chosen
from estimation.compiled_stage import CompiledStage
from estimation.function_call import FunctionCall
from estimation.interpreted_stage import InterpretedStage
from estimation.status import Status
from estimation.symbolic_stage import (
    difference_function,
    predict_function,
    retract_function,
    update_function,
)
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


@dataclass(frozen=True, eq=False)
class Prediction:
    """Result of a prediction.

    Parameters
    ----------
    state : x⁻ and P⁻
    reached, deviation : f(x̃, w̃) and δ⁻ (n_x,), of which x⁻ is made
    F, G : (n_x, n_x), (n_x, n_w)
    """

    state: GaussianState
    reached: Array
    deviation: Array
    F: Array
    G: Array


@dataclass(frozen=True, eq=False)
class Update:
    """Result of an update.

    Parameters
    ----------
    state : x⁺ and P⁺
    deviation : δ⁺ (n_x,), of x⁺ from the linearisation point
    innovation : v (n_r,), zero in missing rows
    innovation_covariance : S (n_r, n_r)
    W, e, H, L : (n_x, n_r), (n_r,), (n_r, n_x), (n_r, n_r), what a backward pass needs
    present : (n_r,) rows that had a reading
    """

    state: GaussianState
    deviation: Array
    innovation: Array
    innovation_covariance: Array
    W: Array
    e: Array
    H: Array
    L: Array
    present: NDArray[np.bool_]


class KalmanStage:
    """The stage on NumPy arrays, compiled where a C compiler is found.

    Loops in C have it without this class around; both engines say the same to the last bit. One
    instance belongs to one estimator: it owns work buffers.
    """

    def __init__(self, model: StateSpaceModel) -> None:
        self.model = model
        self._made = chosen(
            lambda: CompiledStage(model), lambda: InterpretedStage(model, *self.functions)
        )
        self._retract = FunctionCall(retract_function(model))
        self._difference = FunctionCall(difference_function(model))
        self._no_noise, self._unit_noise = np.zeros(model.n_w), np.ones(model.n_w)
        self._no_deviation = np.zeros(model.n_x)

    @cached_property
    def functions(self) -> tuple[ca.Function, ca.Function]:
        """Predict and update, symbolically."""
        return predict_function(self.model), update_function(self.model)

    def predict(
        self,
        state: GaussianState,
        dt: float,
        x_lin: Array | None = None,
        w_lin: Array | None = None,
        noise_scale: Array | None = None,
        deviation: Array | None = None,
        *,
        inputs: Sequence[Array] = (),
    ) -> Prediction:
        """Return x⁻, P⁻ after `dt` seconds, linearised at (x_lin, w_lin).

        The filter's own mean and no noise are the default linearisation point.

        Parameters
        ----------
        noise_scale : (n_w,) standard deviations of the noises; ones by default
        deviation : (n_x,) δ⁺ of the mean from x_lin, where it is known; it may be longer
            than the difference of two states can tell
        inputs : (n_u,) at both ends of the step, where the model has some; see `step_inputs` of
            `models.state_space.StateSpaceModel`

        Raises
        ------
        ValueError
            If the model has inputs and none are given, or the other way round.
        """
        if bool(inputs) != bool(self.model.n_u):
            raise ValueError(f"{len(inputs)} inputs, expected those of both ends of the step")
        reached, d_minus, known, F, G = self._made.predict(
            self._deviation(state.mean, x_lin) if deviation is None else deviation,
            state,
            state.mean if x_lin is None else x_lin,
            self._no_noise if w_lin is None else w_lin,
            dt,
            self._unit_noise if noise_scale is None else noise_scale,
            *inputs,
        )
        predicted = replace(known, mean=self.retract(reached, d_minus))
        return Prediction(predicted, reached, d_minus, F, G)

    def retract(self, x: Array, deviation: Array) -> Array:
        """Return x ⊞ δ (n_x,)."""
        return self._retract(x, deviation)[0]

    def difference(self, to: Array, origin: Array) -> Array:
        """Return to ⊟ origin (n_x,)."""
        return self._difference(to, origin)[0]

    def _deviation(self, mean: Array, x_lin: Array | None) -> Array:
        return self._no_deviation if x_lin is None else self._difference(mean, x_lin)[0]

    def update(
        self,
        state: GaussianState,
        y: Array,
        present: NDArray[np.bool_] | Array | None = None,
        x_lin: Array | None = None,
        deviation: Array | None = None,
    ) -> Update:
        """Condition x⁻, P⁻ on a row of readings, NaN where missing, linearised at x_lin.

        Parameters
        ----------
        deviation : (n_x,) δ⁻, as for `predict`
        present : (n_r,) rows to use, or their scales; those of `rows_present` by default
        """
        if present is None:
            present = rows_present(self.model, y)
        at = state.mean if x_lin is None else x_lin
        d_plus, known, v, S, W, e, H, L = self._made.update(
            self._deviation(state.mean, x_lin) if deviation is None else deviation,
            state,
            at,
            without_gaps(y),
            np.asarray(present, dtype=float),
        )
        updated = replace(known, mean=self.retract(at, d_plus))
        return Update(updated, d_plus, v, S, W, e, H, L, np.asarray(present) != 0)

    def sweep(self, known: GaussianState, times: Array, x: Array, y: Array) -> Array:
        """Return the covariances (n, n_x, n_x) that n rows of readings leave along known states.

        Parameters
        ----------
        known : in front of the first row; its mean is not used
        times, x, y : (n,) s, (n, n_x), (n, n_row) as of `estimation.recording.Recording.stacked`
        """
        present = np.array([rows_present(self.model, row) for row in y], dtype=float)
        dt = np.diff(times, prepend=times[:1])
        return self._made.sweep(known, x, dt, without_gaps(y), present)

    def remark(self) -> Status:
        """Return whether an update since the last call has lost its digits."""
        return Status.DIGITS_LOST if self._made.lost() else Status.SOLVED


def rows_present(model: StateSpaceModel, y: Array) -> NDArray[np.bool_]:
    """Return which rows (n_r,) of the stacked residual have all readings they need.

    A reading that is NaN, infinite or at its sensor's range limit counts as missing.
    """
    usable = np.abs(y[: model.n_y]) < model.saturation
    missing: NDArray[np.bool_] = model.row_needs @ ~usable
    return ~missing


def without_gaps(y: Array) -> Array:
    """Return a row with zero where there is no reading, as symbols need numbers.

    Its inputs are all there: see `estimation.inputs`.
    """
    return np.where(np.isfinite(y), y, 0.0)
