from __future__ import annotations

import collections

import numpy as np
import pytest

from classical_baseline.fixed_weight import FixedWeightConfig, run
from ekf_baseline.interpreted import FIRST
from estimation.estimator import run as drive
from estimation.function_call import FunctionCall
from estimation.symbolic_stage import stage_functions
from mhe.config import WindowConfig
from mhe.stage_functions import pass_functions, window_functions
from models.turntable import turntable_model
from pen_mhe.estimators import create_estimator, settings_read
from suites.tilt.cases import CASES
from suites.tilt.operations import ekf_operations, mhe_operations, operations
from suites.tilt.recursion import raw_function, recursion_function, run_compiled, run_raw_compiled
from suites.tilt.samples import SENSORS, installed, simulate_samples


@pytest.mark.parametrize("weight", [0.0, 0.25, 20.0, 300.0])
@pytest.mark.parametrize("case", ["full turn, fast", "full turn, two axes"])
def test_machine_code_says_the_same(weight: float, case: str) -> None:
    samples = simulate_samples(CASES[case], 0)
    given = samples.time_s, samples.acceleration_g, samples.rates
    found, seconds = run_compiled(weight, *given)
    np.testing.assert_allclose(found, run(FixedWeightConfig(weight), *given), atol=1e-12)
    assert (seconds > 0).all()


def test_raw_machine_code_normalises() -> None:
    samples = simulate_samples(CASES["rest"], 0)
    found, _ = run_raw_compiled(samples.acceleration_g)
    lengths = np.linalg.norm(samples.acceleration_g, axis=1, keepdims=True)
    np.testing.assert_allclose(found, samples.acceleration_g / lengths, atol=1e-15)


def test_operations_by_hand() -> None:
    # Three squares, two sums, a root, the guard, three quotients.
    assert operations(raw_function()) == 10
    # Rates 6 with the products by T, angles 4, sines and cosines 4, side 2 + 2 + 2, sizes and
    # products 3 + 2, sign 1, three vectors normalised 3 × 10, weighed and summed 6 and w.
    assert 55 <= operations(recursion_function()) <= 70


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize(
    "estimator", ["ekf", "mhe-rti", pytest.param("mhe", marks=pytest.mark.slow)]
)
def test_operations_are_those_that_are_called(
    estimator: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Count the calls of the interpreted estimators: the same stages, called one by one.

    Operations are those of full passes; stages that keep their factors need fewer.
    """
    counted: collections.Counter[str] = collections.Counter()
    plain = FunctionCall.__call__

    def counting(self: FunctionCall, *arguments: object) -> object:
        counted[self.function.name()] += 1
        return plain(self, *arguments)  # type: ignore[arg-type]

    case = CASES["full turn, fast"]
    model = turntable_model(installed(case.installation), SENSORS)
    full = settings_read(estimator, {"reuse_threshold": 0.0})
    chosen = create_estimator(estimator, model, **full)
    recording = simulate_samples(case, 0).recording(9.81)
    horizon = WindowConfig().horizon
    # Windows are full, and an EKF's updates settle no longer.
    filled, steps = (horizon + 5) / 100 + FIRST["SETTLING_S"], 10
    drive(chosen, recording.first(filled))
    monkeypatch.setattr(FunctionCall, "__call__", counting)
    before = drive(chosen, recording.first(filled))
    of_filling = counted.copy()
    history = drive(chosen, recording.first(filled + steps / 100))
    counted -= of_filling
    counted -= of_filling
    if estimator == "ekf":
        expected: float = ekf_operations(model)
        own = 0.0
    else:
        passes = history.iterations[len(before) :].mean()
        expected = mhe_operations(model, horizon, passes, searches=estimator == "mhe")
        own = 2 * horizon * passes
    stage = stage_functions(model)
    functions = (*stage, *window_functions(model), *pass_functions(model, *stage[:2]))
    of = {f.name(): operations(f) for f in functions}
    found = sum(of[name] * calls for name, calls in counted.items()) / steps
    # The interpreter brings the mean of every stage back within a turn, before and after its
    # readings, which C leaves alone; regularity, one operation here, is no call of its own there.
    expected += own * of["retract"]
    assert 0.995 * expected < found < 1.05 * expected
