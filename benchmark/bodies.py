"""Bodies that move, with their bounds: what windows of several suites are cut from."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from estimation.recording import Recording
from models.motion import white_jerk_motion
from models.pen import pen_model
from models.pen_config import PenConfig
from models.pen_file import load_pen
from models.sensor_kinds.table import Sensor
from models.state_space import StateSpaceModel
from models.turntable import TILTS, TurntableConfig, paper_turntable, turntable_model
from recordings.simulate_pen import simulate
from recordings.simulate_turntable import simulate_table

NO_BIAS: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {
        "accel": {"bias_std_m_s2": 0.0, "bias_walk_m_s2_per_sqrt_s": 0.0},
        "gyro": {"bias_std_rad_s": 0.0, "bias_walk_rad_s_per_sqrt_s": 0.0, "axes": ("x", "y")},
    }
)
"""Sensor → what becomes of it in the pen of [Pen]: no bias states, and no third rate."""


PAPER_MOTION = white_jerk_motion(tip=10.0, attitude=20.0)
"""Of the pen of [Pen], whose acceleration is constant but for noise (3)."""

MOTION = "handwriting"


Bounds = Mapping[str, tuple[float, float]]


WRITING_HAND: Bounds = MappingProxyType(
    {
        "tip_z_m": (0.0, math.inf),
        "tip_x_velocity_m_s": (-0.06, 0.06),
        "tip_y_velocity_m_s": (-0.06, 0.06),
        "tip_z_velocity_m_s": (-0.03, 0.03),
    }
)
"""Of `MOTION`, as far as windows are cut from it: the tip stays above its paper and gets no faster.
Without a camera nothing else says where the tip is, and the estimate drifts off by metres."""


RAISED_PAPER: Bounds = MappingProxyType({"tip_z_m": (0.003, math.inf)})
"""Half a millimetre above the mean height of the tip in `MOTION`: a camera sees the tip below
for more than half of the time."""


@dataclass(frozen=True)
class BoundedBody:
    """What moves: how to write down its model, and how to record it.

    Parameters
    ----------
    config : the pen or turntable as data, with the sensors that are used and no other
    model : the state-space model, without bounds
    record : duration (s) and seed → a simulated recording
    bounds : state → (lower, upper), of the bounded problem: several stages of most windows
        touch them
    """

    config: PenConfig | TurntableConfig
    model: Callable[[], StateSpaceModel]
    record: Callable[[float, int], Recording]
    bounds: Bounds


def _pen_body(pen: PenConfig, bounds: Bounds) -> BoundedBody:
    return BoundedBody(
        pen,
        # The sensors as they are: a writing area would be a sixth to eighth row.
        lambda: pen_model(pen, writing_area=False),
        lambda duration_s, seed: simulate(
            pen, None, motion=MOTION, duration_s=duration_s, seed=seed
        ),
        bounds,
    )


def _turntable() -> BoundedBody:
    """Two tilts; its drives keep to their rates, so bounded they get no faster."""
    table = paper_turntable()
    rates = {
        f"{tilt}_rate_rad_s": (-math.inf, axis.rate_rad_s)
        for tilt, axis in zip(TILTS, table.axes, strict=True)
    }
    return BoundedBody(
        table,
        lambda: turntable_model(table),
        lambda duration_s, seed: simulate_table(table, duration_s, seed),
        rates,
    )


def _pen15() -> BoundedBody:
    """Five degrees of freedom, (1) and (9) of [Pen]: 15 states, 5 rows, no bias."""
    pen = load_pen("reference")
    sensors: dict[str, Sensor] = {
        name: pen.sensors[name].model_copy(update=dict(change)) for name, change in NO_BIAS.items()
    }
    change = {"degrees_of_freedom": 5, "motion": PAPER_MOTION, "sensors": sensors}
    return _pen_body(pen.model_copy(update=change), WRITING_HAND)


def _pen24() -> BoundedBody:
    """Six degrees of freedom and six biases: 24 states; a camera at its own rate of 30 Hz."""
    pen = load_pen("reference")
    sensors = {name: pen.sensors[name] for name in ("accel", "gyro", "camera")}
    return _pen_body(pen.model_copy(update={"sensors": sensors}), RAISED_PAPER)


BODIES: Mapping[str, Callable[[], BoundedBody]] = MappingProxyType(
    {"turntable": _turntable, "pen15": _pen15, "pen24": _pen24}
)
"""Name → what moves."""
