"""Windows from a seeded table."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from benchmark.configurations import CONFIGURATIONS, TURNTABLE_CONFIGURATIONS
from estimation.kalman_stage import rows_present
from models.errors import InputError
from suites.classics.problems import PROBLEMS
from suites.gyro_free.cases import TWO_ACCELS
from suites.optimum.cases import (
    HORIZONS,
    WindowKey,
    rolled_out,
    window_bodies,
    window_case,
    window_key,
)
from suites.optimum.kinds import KINDS

LENT = ("gyro-free two accels", "classic gas_2A_to_B")
MODELS = ("turntable accel+gyro", "pen5 two accelerometers", "pen6 accel+gyro+camera")


def test_a_table_meets_every_model_kind_and_horizon() -> None:
    table = [window_key(seed) for seed in range(1000)]
    assert [key.seed for key in table] == list(range(1000))
    bodies = window_bodies()
    first = {(key.model, key.kind) for key in table[: len(KINDS) * len(bodies)]}
    assert first == {(name, kind) for name, body in bodies.items() for kind in body.kinds}
    for name, kind in first:
        met = {key.horizon for key in table if (key.model, key.kind) == (name, kind)}
        assert met == set(bodies[name].horizons.get(kind) or HORIZONS)


def test_the_table_has_every_configuration_and_every_classic() -> None:
    names = list(window_bodies())
    assert [name for name in names if name.startswith("pen6")] == [
        f"pen6 {row}" for row in CONFIGURATIONS
    ]
    assert {f"turntable {row}" for row in TURNTABLE_CONFIGURATIONS} <= set(names)
    assert {f"classic {case}" for case in PROBLEMS} <= set(names)
    assert f"gyro-free {TWO_ACCELS}" in names


@pytest.mark.parametrize(
    ("model", "kind"),
    [*product(MODELS, KINDS), *((name, kind) for name in LENT for kind in ("plain", "missing"))],
)
def test_a_window_is_whole_and_always_the_same(model: str, kind: str) -> None:
    key = WindowKey(7, model, kind, 6)
    case, again = window_case(key), window_case(key)
    assert (case.guess.states[0] >= case.model.lower).all()
    assert len(case.measurements) == len(case.guess.states) == key.horizon + 1
    assert (np.diff([m.time_s for m in case.measurements]) > 0).all()
    assert np.isfinite(np.linalg.cholesky(case.prior.covariance)).all()
    guess = rolled_out(case.model, case.guess.states[0], case.measurements)
    np.testing.assert_array_equal(guess.states, case.guess.states)
    assert not case.guess.noises.any()
    np.testing.assert_array_equal(case.prior.mean, again.prior.mean)
    np.testing.assert_array_equal(case.guess.states, again.guess.states)
    for one, other in zip(case.measurements, again.measurements, strict=True):
        np.testing.assert_array_equal(one.y, other.y)


@pytest.mark.parametrize("model", MODELS)
def test_kinds_are_what_they_say(model: str) -> None:
    seeds = range(6)
    cases = {
        kind: [window_case(WindowKey(seed, model, kind, 6)) for seed in seeds] for kind in KINDS
    }

    def rows(kind: str) -> int:
        return sum(
            int(rows_present(case.model, m.y).sum())
            for case in cases[kind]
            for m in case.measurements
        )

    assert rows("missing") < 0.9 * rows("plain")
    for case in cases["bad start"]:
        away = case.model.difference(case.prior.mean, case.model.prior.mean).full().ravel()
        angles = np.array(
            [name.endswith("_rad") or "mrp" in name for name in case.model.state_names]
        )
        assert angles.any()
        assert 0.5 <= np.linalg.norm(away[angles]) <= 1.0 + 1e-12
        assert not away[~angles].any()
        np.testing.assert_array_equal(case.prior.covariance, case.model.prior.covariance)
    starts = [
        case.model.difference(case.guess.states[0], case.prior.mean).full().ravel().any()
        for case in cases["bad start"]
    ]
    assert 0 < sum(starts) < len(starts)


def test_what_is_no_window() -> None:
    with pytest.raises(InputError, match="model pen7 is unknown, expected one of pen5 accel"):
        window_case(WindowKey(0, "pen7", "plain", 5))
    with pytest.raises(InputError, match="window kind calm is unknown, expected one of plain"):
        window_case(WindowKey(0, "pen5 accel", "calm", 5))
