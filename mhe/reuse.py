"""Which stages keep their factors when the window slides: the threshold.

A kept stage is eliminated, when it leaves, where its factors were made: about where the arrival
cost ``smoothed`` has it. Where sensors hold all states the newest state is then a few thousandths
of its standard deviation from that of full passes, whatever the threshold. Most passes get
three to four times as fast with N = 20, ten times with N = 100 (`pen-mhe benchmark real-time`):
what takes time is the few stages that moved, not the horizon. Where sensors do not hold all states
(no camera: heading, position, and in its wake the elevation are not observable), what an
estimator claims of such a direction follows from its linearisation points alone, and by
default every pass is a full one.
"""

from __future__ import annotations

from estimation.symmetry import holds
from mhe.config import RealTimeConfig
from models.state_space import StateSpaceModel

REUSE_THRESHOLD = 0.5
"""How far from its linearisation point a stage keeps its factors: its estimate in standard
deviations P⁺, and what its readings would be off by in those of their noise. The first alone
would not do: where a slow camera comes late, P⁺ is wide."""
SETTLED = 0.5
"""Share of the threshold: the pass back ends where no older stage is off by more. It changes which
stages move, and hardly the newest state: that one is the filter's on these factors."""
STEP_S = 0.01
"""Of the motion along which symmetries are tried."""


def reuse_threshold(model: StateSpaceModel, config: RealTimeConfig) -> float:
    """Return the threshold in standard deviations, 0 where every pass is a full one.

    Factors stay only with an arrival cost that eliminates the dropped stage, and with
    noises that are weighed by least squares. Readings with a loss are weighed where their stage is
    linearised, so weights stay with the factors that are made of them.
    """
    if config.arrival_cost not in ("filtered", "smoothed") or config.sparse_noise is not None:
        return 0.0
    threshold = config.scheme.reuse_threshold
    if threshold is not None:
        return threshold
    return REUSE_THRESHOLD if sensors_hold_all(model) else 0.0


def sensors_hold_all(model: StateSpaceModel) -> bool:
    """Return whether no constant reading stands in for a sensor and no symmetry is hidden."""
    if any(sensor.constant_reading is not None for sensor in model.sensors):
        return False
    states = model.prior.mean[None]
    return not any(holds(model, symmetry, states, STEP_S) for symmetry in model.symmetries)
