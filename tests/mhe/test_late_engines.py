"""Late readings in compiled C and around the interpreted stage: the same."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from estimation.recording import Measurement
from estimation.status import Status
from mhe.realtime import Mhe, MheRti
from models.state_space import StateSpaceModel
from tests.closeness import estimate_error
from tests.configs import config_for
from tests.engines import compiled_and_interpreted, needs_compiler, steps
from tests.estimation import pens
from tests.linear_models import constant_acceleration_system, coupled_system, irregular_times
from tests.mhe.late_streams import is_late, late_stream
from tests.mhe.test_deadline import Ticking

pytestmark = needs_compiler

RUN = pens.draw_pen_run(30, seed=11)


def pen_case() -> tuple[StateSpaceModel, list[Measurement]]:
    return RUN.model, late_stream(RUN.model, RUN.measurements, np.random.default_rng(2))


def coupled_case() -> tuple[StateSpaceModel, list[Measurement]]:
    system, rng = coupled_system(3), np.random.default_rng(17)
    measurements = system.simulate(irregular_times(26, rng), rng, missing=0.2)
    return system.model, late_stream(system.model, measurements, rng)


def bounded_case() -> tuple[StateSpaceModel, list[Measurement]]:
    system, rng = constant_acceleration_system(1), np.random.default_rng(6)
    measurements = system.simulate(np.cumsum(rng.uniform(0.05, 0.2, 30)), rng, missing=0.0)
    level = float(np.median([m.y[0] for m in measurements]))
    model = system.model.bounded(s0_m=(-np.inf, level))
    return model, late_stream(model, measurements, rng)


def walled_case() -> tuple[StateSpaceModel, list[Measurement]]:
    """A curved row."""
    model, stream = pen_case()
    floor = float(np.quantile(RUN.truth[:, 2], 0.4))
    wall = model.bounded(tip_z_m=(floor, np.inf))
    return wall.constrained(lambda x: ca.sumsqr(x[:2] / 0.3) - 1), stream


CASES = {
    "pen": pen_case(),
    "coupled": coupled_case(),
    "bounded": bounded_case(),
    "walled": walled_case(),
}
LOSSES: dict[str, Any] = {"huber": {"accel": 1.5}, "sparse_noise": 1.0}
SETTINGS: list[tuple[str, dict[str, Any]]] = [
    ("pen", {}),
    ("pen", {"reuse_threshold": 0.5}),
    ("pen", {"reuse_threshold": 0.5, "arrival_cost": "filtered", "lag_samples": (2, 4)}),
    ("pen", {"arrival_cost": "constant"}),
    ("pen", {"arrival_cost": "none"}),
    ("pen", LOSSES),
    ("pen", {**LOSSES, "arrival_cost": "filtered", "lag_samples": (1, 3)}),
    ("coupled", {"reuse_threshold": 0.5}),
    ("bounded", {"lag_samples": (2,)}),
    ("walled", {}),
]


CHEAP = ("coupled", "bounded")


@pytest.mark.parametrize(
    ("name", "settings", "kind"),
    [
        *((*row, MheRti) for row in SETTINGS),
        *(
            pytest.param(*row, Mhe, marks=() if row[0] in CHEAP else pytest.mark.slow)
            for row in SETTINGS
        ),
    ],
)
def test_every_step(
    name: str,
    settings: dict[str, Any],
    kind: type[Mhe] | type[MheRti],
    request: pytest.FixtureRequest,
) -> None:
    if name == "walled":
        request.getfixturevalue("optimised")
    model, stream = CASES[name]
    config = config_for(kind, horizon=9, **settings)
    machine, plain = compiled_and_interpreted(lambda: kind(model, config))
    constrained = name in ("bounded", "walled")
    tolerance = (1e-6 if constrained else 1e-9) if kind is Mhe else 1e-9 if constrained else 1e-12
    late = 0
    for k, (a, b) in enumerate(zip(steps(machine, stream), steps(plain, stream), strict=True)):
        assert estimate_error(model, a, b) < tolerance
        assert a.status is b.status
        assert a.time_s == b.time_s
        assert [(x.lag, x.time_s) for x in a.lagged] == [(x.lag, x.time_s) for x in b.lagged]
        for x, y in zip(a.lagged, b.lagged, strict=True):
            std = y.state.std
            assert np.abs((x.state.mean - y.state.mean) / std).max() < 1e3 * tolerance
            off = np.abs(x.state.covariance - y.state.covariance) / np.outer(std, std)
            assert off.max() < 1e3 * tolerance
        late += is_late(stream, k) and Status.LATE not in a.status
    assert late >= 8


@pytest.mark.cover
@pytest.mark.parametrize("kind", [MheRti, Mhe])
@pytest.mark.parametrize("tick", [0.6, 0.35, 0.1, 0.04, 0.01])
def test_both_engines_stand_on_the_same_rung(tick: float, kind: type[Mhe] | type[MheRti]) -> None:
    """They read the clock equally often, also where a reading is late."""
    model, stream = CASES["pen"]
    config = config_for(kind, horizon=6, deadline_s=1.0, reuse_threshold=0.05)
    clocks = iter([Ticking(tick), Ticking(tick)])
    machine, plain = compiled_and_interpreted(lambda: kind(model, config, clock=next(clocks)))
    statuses = set()
    for a, b in zip(steps(machine, stream), steps(plain, stream), strict=True):
        assert (a.status, a.iterations) == (b.status, b.iterations)
        assert estimate_error(model, a, b) < 1e-9
        statuses |= set(a.status)
    assert (Status.PREDICTED in statuses) == (tick > 0.1)
