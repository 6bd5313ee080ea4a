"""The pens and the turntable as bodies that windows are cut from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from benchmark.configurations import CONFIGURATIONS, TURNTABLE_CONFIGURATIONS, contract_models
from models.pen_file import load_pen
from models.state_space import StateSpaceModel
from models.turntable import paper_turntable
from recordings.motion_list import DRAWN
from recordings.simulate_pen import simulate, simulate_model
from recordings.simulate_turntable import simulate_table
from suites.optimum.kinds import KINDS
from suites.windows import Recorded, WindowBody

NO_SPIN_CONFIGURATIONS = ("accel", "gyro", "accel+gyro", "accel+gyro+camera", "two accelerometers")
"""Configurations of the pen that cannot spin whose windows are solved; of the free pen, all."""


def own_bodies() -> Mapping[str, WindowBody]:
    """Return pens, then turntables, by name."""
    known, kinds = contract_models(), tuple(KINDS)
    rows = [(5, name) for name in NO_SPIN_CONFIGURATIONS] + [(6, name) for name in CONFIGURATIONS]
    pens = {f"pen{dof} {name}": dof for dof, name in rows}
    records: dict[str, Callable[..., Recorded]] = {
        **{name: partial(_pen, known[name], dof) for name, dof in pens.items()},
        **{
            name: partial(_table, known[name])
            for name in (f"turntable {row}" for row in TURNTABLE_CONFIGURATIONS)
        },
    }
    return {
        name: WindowBody(known[name], _step_s(known[name]), record, kinds)
        for name, record in records.items()
    }


def _step_s(model: StateSpaceModel) -> float:
    return 1 / max(sensor.rate_hz for sensor in model.measured_sensors if sensor.rate_hz)


def _pen(
    model: StateSpaceModel,
    degrees_of_freedom: int,
    kind: str,
    duration_s: float,
    rng: np.random.Generator,
) -> Recorded:
    row, seed = KINDS[kind], int(rng.integers(2**31))
    pen = load_pen("reference").model_copy(update={"degrees_of_freedom": degrees_of_freedom})
    motion = str(rng.choice(row.motions))
    speed = 1.0 if motion == DRAWN else float(rng.uniform(*row.speed))
    sensors = [sensor.name for sensor in model.measured_sensors]
    recording = simulate(pen, sensors, motion=motion, duration_s=duration_s, seed=seed, speed=speed)
    return recording, model.prior


def _table(
    model: StateSpaceModel, kind: str, duration_s: float, rng: np.random.Generator
) -> Recorded:
    seed = int(rng.integers(2**31))
    if rng.choice(KINDS[kind].table_motions) == DRAWN:
        return simulate_model(model, duration_s=duration_s, seed=seed), model.prior
    return simulate_table(paper_turntable(), duration_s, seed), model.prior
