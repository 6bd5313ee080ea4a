"""The extended Kalman filter: the shared stage, linearised at its own mean."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ekf_baseline.interpreted import FIRST, InterpretedFilter
from ekf_baseline.outliers import OUTLIERS, gate_limits
from ekf_baseline.state import EkfState, check_late_samples, filter_memory, first_filter, kept_for
from estimation.chosen import chosen
from estimation.collect import Batches
from estimation.engine import CompiledEngine, Loop
from estimation.estimate import Estimate, EstimateHistory
from estimation.exclusive import Exclusive, in_turn
from estimation.intervals import check_step
from estimation.linearisation import loop_functions
from estimation.losses import checked_gates, checked_thresholds, of_sensors
from estimation.recording import Measurement
from estimation.rest import rest_constants, rest_fields
from estimation.result import Engine, ResultReader
from estimation.settings import checked_config
from estimation.stored import padded, stride
from estimation.symbolic_stage import difference_function
from models.arrays import Array
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
    late_samples : how many measurements back it takes a late one, at least; more reaches further
        and needs more memory, 0 keeps nothing and takes none. None follows from the model: twice as
        many as all its sensors' rates give within the longest of their delays, at least 20
    huber : sensor → threshold in standard deviations of the sensor's whole innovation, beyond which
        its noise counts as larger, so that it moves the state by no more than that; smaller
        trusts a reading far off less, a sensor that is not named is weighed by least squares

    Raises
    ------
    InputError
        If a gate is not a probability, a threshold not positive, or the number of measurements
        negative.
    """

    gate_probability: float | Mapping[str, float] | None = None
    late_samples: int | None = None
    huber: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_late_samples(self.late_samples)
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


class Ekf(Exclusive):
    """Extended Kalman filter on a state-space model.

    Each step predicts to the measurement's time and updates with the readings
    it has, both linearised at the filter's current mean. From the first reading of a sensor
    until 0.3 s behind it an update is linearised at its own posterior, iterated until that stays: a
    start two deviations off would otherwise leave a wrong tilt for good, and a compass a wrong
    heading, as a tilt of some degrees is still to come in behind the first reading.

    A measurement older than the newest is taken at its own instant: the filter goes back to a
    state that it kept and makes all that followed again. What it then says is, to the last bit,
    what it would have said had they come in order.

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
        super().__init__(model, self.config)
        self._kept = kept_for(model, self.config.late_samples)
        self._engine = chosen(
            lambda: CompiledEngine(model, filter_loop(model, self.config)),
            lambda: InterpretedFilter(model, self._kept, *outlier_limits(model, self.config)),
        )
        self._layout = self._engine.memory
        self._reader = ResultReader(model)
        self._batches = Batches(self.name, self._reader, self._engine.memory, self._engine.batch)

    def init(self, prior: Prior | None = None) -> EkfState:
        """Return the state before the first measurement, from the model's prior or another.

        Raises
        ------
        InputError
            If the prior is not of the model's size.
        """
        return first_filter(self.model, self._kept, prior)

    @in_turn
    def step(self, state: EkfState, measurement: Measurement) -> tuple[EkfState, Estimate]:
        """Predict to the measurement's time and update; one that is late changes what followed."""
        if (newest_s := state.time_s) is not None:
            check_step(self.model, *sorted((newest_s, measurement.time_s)))
        return self.told(*self._engine.step(state.memory, measurement.time_s, measurement.y))

    @property
    def engine(self) -> Engine:
        """What makes its steps."""
        return self._engine

    def told(self, memory: Array, result: Array) -> tuple[EkfState, Estimate]:
        """Return the state and the estimate of a step of the engine."""
        return EkfState(memory, self._layout), self._reader.estimate(result)

    @in_turn
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
        memory, history = self._batches.take(state.memory, time_s, y, covariances, on_progress)
        return EkfState(memory, state.layout), history


def outlier_limits(model: StateSpaceModel, config: EkfConfig) -> tuple[Array | None, Array | None]:
    """Return limits of gates, see `gate_limits`, and thresholds (n_sensors,); None for none."""
    sensors = [sensor.name for sensor in model.sensors]
    huber = of_sensors(config.huber, sensors, "Huber's loss")
    thresholds = np.array([huber.get(name, np.inf) for name in sensors]) if huber else None
    return gate_limits(model, config.gates(sensors)), thresholds


def filter_loop(model: StateSpaceModel, config: EkfConfig) -> Loop:
    """Return the filter's loop, ekf_baseline/filter.c and late.c, for a model."""
    n_x, n_w, n_r = model.n_x, model.n_w, model.n_r
    row, kept = stride(n_x), kept_for(model, config.late_samples)
    memory = filter_memory(model, kept)
    own = memory.slices["count"].start if kept.capacity else 0
    gate, huber = outlier_limits(model, config)
    return Loop(
        sources=[Path(__file__).with_name(name) for name in ("filter.c", "late.c")],
        entry="filter",
        memory=memory,
        functions=[*loop_functions(model), difference_function(model)],
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
            "capacity": kept.capacity,
            "spacing": kept.spacing,
            "other": np.zeros(own),
            **{name: np.zeros(n_r) for name in ("told", "late_v", "late_used")},
            "late_S": np.zeros((n_r, n_r)),
            **rest_fields(model),
        },
        constants={**FIRST, **OUTLIERS, **rest_constants(model)},
    )
