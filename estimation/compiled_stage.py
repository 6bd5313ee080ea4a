"""The Kalman stage in compiled C, on NumPy arrays; see `estimation.kalman_stage`."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.layout import Layout
from estimation.linearisation import loop_functions, triangle
from estimation.loop import Loop, model_fields
from estimation.machine import Machine, address, kernel, kernel_fields
from estimation.stored import restored, stored, stride
from models.arrays import Array
from models.gaussian import GaussianState
from models.state_space import StateSpaceModel


class CompiledStage:
    """Predict and update of a model; one instance owns work buffers, for one thread."""

    def __init__(self, model: StateSpaceModel) -> None:
        self._model, self._machine, functions = model, Machine(), loop_functions(model)
        alone = Loop([], "stage", Layout("Memory", {}), functions, {})
        fields = {**model_fields(model, alone), **kernel_fields()}
        described: Any = self._machine.structure("Model", fields)
        self._machine.load(functions, [described], [kernel(model, type(described))])
        self._self, self._lost = ctypes.addressof(described), fields["lost"]
        pointer = ctypes.c_void_p
        self._predict = ctypes.CFUNCTYPE(None, *[pointer] * 9)(described.predict.value)
        self._update = ctypes.CFUNCTYPE(None, *[pointer] * 7)(described.update.value)
        sweep = ctypes.CFUNCTYPE(None, pointer, ctypes.c_longlong, *[pointer] * 8)
        self._sweep = sweep(described.sweep.value)
        transition, readings, *_ = functions
        n_x, n_w, n_r, row = model.n_x, model.n_w, model.n_r, stride(model.n_x)
        patterns = transition.sparsity_out(1), transition.sparsity_out(2), readings.sparsity_out(1)
        F, G, H = (np.array(s.get_triplet(), dtype=int).reshape(2, -1) for s in patterns)
        self._F_at, self._G_at, self._H_at = (F[1], F[0]), (G[0], G[1]), (H[1], H[0])
        self._L_at = np.tril_indices(n_r)
        self._unit = np.diag(fields["F_unit"][:n_x])
        self._predicted = [np.zeros(size) for size in (n_x, n_x, row * row, F.shape[1], G.shape[1])]
        self._updated = [
            np.zeros(size)
            for size in (n_x, row * row, n_r, n_r * n_r, n_r * row, n_r, H.shape[1], triangle(n_r))
        ]
        self._results = [_pointers(self._predicted), _pointers(self._updated)]
        self._no_inputs = [np.zeros(0), np.zeros(0)]
        self._row, self._shape = row, (n_x, n_w, n_r)

    def predict(
        self,
        deviation: Array,
        state: GaussianState,
        x: Array,
        w: Array,
        dt: float,
        scale: Array,
        *inputs: Array,
    ) -> tuple[Array, Array, GaussianState, Array, Array]:
        """Return f(x̃, w̃), δ⁻, P⁻ around no mean yet, F (n_x, n_x) and G (n_x, n_w)."""
        n_x, n_w, _ = self._shape
        given = [_doubles(a) for a in (deviation, stored(state), x, w, np.array(dt), scale)]
        ends = [_doubles(a) for a in inputs] or self._no_inputs
        u = _pointers(ends)
        own = *(address(a) for a in given), ctypes.addressof(u)
        self._predict(self._self, *own, ctypes.addressof(self._results[0]))
        reached, d_minus, P, F_entries, G_entries = self._predicted
        F, G = self._unit.copy(), np.zeros((n_x, n_w))
        F[self._F_at] += F_entries
        G[self._G_at] = G_entries
        return reached.copy(), d_minus.copy(), self._known(P, state.mean), F, G

    def update(
        self, deviation: Array, state: GaussianState, x: Array, y: Array, present: Array
    ) -> tuple[Array, GaussianState, Array, Array, Array, Array, Array, Array]:
        """Return δ⁺, P⁺ around no mean yet, v, S, W (n_x, n_r), e, H (n_r, n_x), L (n_r, n_r)."""
        n_x, _, n_r = self._shape
        given = [_doubles(a) for a in (deviation, stored(state), x, y, present)]
        self._update(self._self, *(address(a) for a in given), ctypes.addressof(self._results[1]))
        d_plus, P, v, S, W_rows, e, H_entries, L_rows = self._updated
        there: NDArray[np.bool_] = given[-1] != 0
        H, L = np.zeros((n_r, n_x)), np.zeros((n_r, n_r))
        H[self._H_at] = H_entries
        L[self._L_at] = L_rows
        L[~there, :] = 0
        L[:, ~there] = 0
        L[~there, ~there] = self._model.noise_std[~there]
        W = np.where(there, W_rows.reshape(n_r, self._row)[:, :n_x].T, 0.0)
        square = S.reshape(n_r, n_r).copy()
        return d_plus.copy(), self._known(P, state.mean), v.copy(), square, W, e.copy(), H, L

    def sweep(self, P: GaussianState, x: Array, dt: Array, y: Array, present: Array) -> Array:
        """Return the covariances (n, n_x, n_x) behind n rows; see `KalmanStage.sweep`."""
        n_x, n_w, _ = self._shape
        kept = np.empty((len(x), self._row, self._row))
        zeros, ones = np.zeros(max(n_x, n_w)), np.ones(n_w)
        given = [_doubles(a) for a in (stored(P), x, dt, y, present, zeros, ones)]
        self._sweep(self._self, len(x), *(address(a) for a in given), address(kept))
        return np.array([self._known(each, x[0]).covariance for each in kept])

    def lost(self) -> bool:
        """Return whether a reading since the last call has left fewer than two digits."""
        lost = bool(self._lost[0])
        self._lost[0] = 0
        return lost

    def _known(self, kept: Array, mean: Array) -> GaussianState:
        return restored(mean, kept.reshape(self._row, self._row).copy())


def _doubles(array: Array) -> Array:
    return np.ascontiguousarray(array, dtype=np.float64)


def _pointers(arrays: list[Array]) -> Any:
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
