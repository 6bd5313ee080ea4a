"""The extended Kalman filter: the shared stage, linearised at its own mean."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ekf_baseline.interpreted import FIRST, InterpretedFilter
from ekf_baseline.outliers import OUTLIERS, gate_limits
from estimation.chosen import chosen
from estimation.collect import Batches
from estimation.engine import CompiledEngine, Loop
from estimation.estimate import Estimate, EstimateHistory
from estimation.estimator import first_state
from estimation.intervals import check_step
from estimation.layout import Layout
from estimation.linearisation import loop_functions
from estimation.losses import checked_gates, checked_thresholds, of_sensors
from estimation.recording import Measurement
from estimation.rest import rest_blocks, rest_constants, rest_fields
from estimation.result import ResultReader
from estimation.settings import checked_config
from estimation.stored import padded, restored, store, stride
from estimation.symbolic_stage import difference_function
from models.arrays import Array
from models.gaussian import GaussianState
from models.given_prior import Prior
from models.state_space import StateSpaceModel


@dataclass(frozen=True, kw_only=True)
class EkfConfig:
    """Settings of the EKF.

    Parameters
    ----------
    gate_probability : a sensor's reading is dropped when its squared
        Mahalanobis distance to the prediction exceeds the χ² quantile of this
        probability; nearer to 1 drops less, None never drops. One number for all sensors, or
        sensor → probability. A gate that rejects several readings in a row opens again, see
        `ekf_baseline.outliers`
    huber : sensor → threshold in standard deviations of the sensor's whole innovation, beyond which
        its noise counts as larger, so that it moves the state by no more than that; smaller
        trusts a reading far off less, a sensor that is not named is weighed by least squares

    Raises
    ------
    InputError
        If a gate is not a probability, or a threshold not positive.
    """

    gate_probability: float | Mapping[str, float] | None = None
    huber: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "gate_probability", checked_gates(self.gate_probability))
        object.__setattr__(self, "huber", checked_thresholds(self.huber))

    def gates(self, sensors: Sequence[str]) -> Mapping[str, float]:
        """Return sensor → probability of its gate; `InputError` for one not among `sensors`."""
        gate = self.gate_probability
        if gate is None:
            return {}
        if isinstance(gate, Mapping):
            return of_sensors(gate, sensors, "a gate")
        return dict.fromkeys(sensors, gate)


@dataclass(frozen=True, eq=False)
class EkfState:
    """Time (None before the first measurement) and Gaussian x_k|k, or the prior x_0|-1.

    ``seen`` (n_sensors,) is 1 for sensors whose readings were used, ``doubt`` (2 n_sensors,) has
    how many of a sensor's readings its gate has rejected in a row, and the time since the first of
    them, s; ``inputs`` (n_u,) are the last known ones, ``rest`` what the detector of rest
    remembers, see `estimation.rest.rest_blocks`; empty where the model has none.
    """

    time_s: float | None
    gaussian: GaussianState
    seen: Array
    doubt: Array
    inputs: Array
    rest: Array


class Ekf:
    """Extended Kalman filter on a state-space model.

    Each step predicts to the measurement's time and updates with the readings
    it has, both linearised at the filter's current mean. An update with the first readings
    of a sensor is linearised at its own posterior, iterated until that stays: a start two
    deviations off would otherwise leave a wrong tilt for good.

    References
    ----------
    Särkkä (2013), Bayesian Filtering and Smoothing, Algorithm 5.4.
    Bell, Cathey (1993), The iterated Kalman filter update as a Gauss-Newton method, IEEE Trans.
    Automatic Control 38(2).
    """

    name = "ekf"

    def __init__(self, model: StateSpaceModel, config: EkfConfig | None = None) -> None:
        self.model = model
        self.config = checked_config(self.name, config, EkfConfig)
        self._engine = chosen(
            lambda: CompiledEngine(model, filter_loop(model, self.config)),
            lambda: InterpretedFilter(
                model, filter_memory(model), *outlier_limits(model, self.config)
            ),
        )
        self._reader = ResultReader(model)
        self._batches = Batches(self.name, self._reader, self._engine.memory, self._engine.batch)

    def init(self, prior: Prior | None = None) -> EkfState:
        """Return the state before the first measurement, from the model's prior or another.

        Raises
        ------
        InputError
            If the prior is not of the model's size.
        """
        return first_filter(self.model, prior)

    def step(self, state: EkfState, measurement: Measurement) -> tuple[EkfState, Estimate]:
        """Predict to the measurement's time and update."""
        check_step(self.model, state.time_s, measurement.time_s)
        memory, result = self._engine.step(packed_state(state), measurement.time_s, measurement.y)
        return self._unpack(memory), self._reader.estimate(result)

    def batch(
        self,
        state: EkfState,
        time_s: Array,
        y: Array,
        *,
        covariances: bool = False,
        on_progress: Callable[[int], None] | None = None,
    ) -> tuple[EkfState, EstimateHistory]:
        """Take n measurements in compiled calls; the same as n steps.

        Parameters
        ----------
        time_s, y : (n,), (n, n_row), as of `estimation.recording.Recording.stacked`
        covariances, on_progress : see `estimation.estimator.run`
        """
        memory, history = self._batches.take(
            packed_state(state), time_s, y, covariances, on_progress
        )
        return self._unpack(memory), history

    def _unpack(self, memory: Array) -> EkfState:
        n_x, row = self.model.n_x, stride(self.model.n_x)
        end = 1 + n_x + row * row
        seen = end + len(self.model.sensors)
        doubt = seen + 2 * len(self.model.sensors)
        inputs = doubt + self.model.n_u
        gaussian = restored(memory[1 : n_x + 1], memory[n_x + 1 : end].reshape(row, row))
        time_s = None if math.isnan(memory.item(0)) else memory.item(0)
        parts = memory[end:seen], memory[seen:doubt], memory[doubt:inputs], memory[inputs:]
        return EkfState(time_s, gaussian, *parts)


def filter_memory(model: StateSpaceModel) -> Layout:
    """Return the layout of the filter's state; ``time_s`` is NaN before the first measurement."""
    n_x, row = model.n_x, stride(model.n_x)
    state = {
        "time_s": (),
        "mean": (n_x,),
        "covariance": (row, row),
        "seen": (len(model.sensors),),
        "doubt": (2 * len(model.sensors),),
        "inputs": (model.n_u,),
    }
    return Layout("Memory", {**state, **rest_blocks(model)})


def first_filter(model: StateSpaceModel, prior: Prior | None) -> EkfState:
    """Return the state before the first measurement; a prior of None is the model's."""
    detector = Layout("RestMemory", rest_blocks(model))
    unseen, trusted = np.zeros(len(model.sensors)), np.zeros(2 * len(model.sensors))
    unknown, rest = np.full(model.n_u, np.nan), np.zeros(detector.size)
    return EkfState(None, first_state(model, prior), unseen, trusted, unknown, rest)


def packed_state(state: EkfState) -> Array:
    """Return a state as one flat array; see `filter_memory`."""
    n_x, row = len(state.gaussian.mean), stride(len(state.gaussian.mean))
    end = 1 + n_x + row * row
    seen = end + len(state.seen)
    doubt = seen + len(state.doubt)
    inputs = doubt + len(state.inputs)
    memory = np.empty(inputs + len(state.rest))
    memory[0] = np.nan if state.time_s is None else state.time_s
    memory[1 : n_x + 1] = state.gaussian.mean
    store(state.gaussian, memory[n_x + 1 : end].reshape(row, row))
    memory[end:seen], memory[seen:doubt] = state.seen, state.doubt
    memory[doubt:inputs], memory[inputs:] = state.inputs, state.rest
    return memory


def outlier_limits(model: StateSpaceModel, config: EkfConfig) -> tuple[Array | None, Array | None]:
    """Return limits of gates, see `gate_limits`, and thresholds (n_sensors,); None for none."""
    sensors = [sensor.name for sensor in model.sensors]
    huber = of_sensors(config.huber, sensors, "Huber's loss")
    thresholds = np.array([huber.get(name, np.inf) for name in sensors]) if huber else None
    return gate_limits(model, config.gates(sensors)), thresholds


def filter_loop(model: StateSpaceModel, config: EkfConfig) -> Loop:
    """Return the filter's loop, ekf_baseline/filter.c, for a model."""
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    row = stride(n_x)
    gate, huber = outlier_limits(model, config)
    return Loop(
        sources=[Path(__file__).with_name("filter.c")],
        entry="filter",
        memory=filter_memory(model),
        functions=[loop_functions(model), [difference_function(model)]],
        fields={
            "gate": gate,
            "huber": huber,
            "prior_P": padded(model.prior.covariance),
            "opens": np.zeros(len(model.sensors)),
            **{name: np.zeros((n_r, n_r)) for name in ("S_wide", "S_added")},
            "P_wide": np.zeros((row, row)),
            "no_deviation": np.zeros(n_x),
            "no_noise": np.zeros(n_w),
            "unit_noise": np.ones(n_w),
            "present": np.zeros(n_r),
            "used": np.zeros(n_r),
            "clean": np.zeros(model.n_row),
            "difference": "difference",
            **{name: np.zeros(n_x) for name in ("x_minus", "x_next", "d_minus", "d_plus")},
            "P_minus": np.zeros((row, row)),
            "v": np.zeros(n_r),
            "S": np.zeros((n_r, n_r)),
            "L": np.zeros((n_r, n_r)),
            "z": np.zeros(n_r),
            "rows": np.zeros(n_r, dtype=np.int64),
            **rest_fields(model),
        },
        constants={**FIRST, **OUTLIERS, **rest_constants(model)},
    )
