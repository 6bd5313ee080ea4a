"""A problem's file: another solver needs nothing else."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from benchmark.bodies import BODIES
from suites.speed.export import problem_arrays, write_problem
from suites.speed.problems import Problem
from suites.speed.windows import solved_windows
from tests.references import speed_problem

DOCS = Path(__file__).resolve().parents[3] / "docs" / "speed.md"

pytestmark = pytest.mark.usefixtures("interpreted")


def test_numpy_alone_reproduces_the_cost(tmp_path: Path) -> None:
    problem = Problem("pen15", 20, 2)
    path = write_problem(problem, problem_arrays(problem, solved_windows(problem, 2)), tmp_path)
    assert path == tmp_path / "problem_pen15_20.npz"
    stored, computed = speed_problem.costs_of_solutions(path)
    assert len(stored) == 2
    np.testing.assert_allclose(computed, stored, rtol=1e-9)
    with np.load(path) as file:
        warm = speed_problem.cost(file, 0, file["warm_states"][0, 0], file["warm_noises"][0])
    assert warm > stored[0] + 0.01


def test_transitions_are_those_of_uneven_steps() -> None:
    """The camera's instants lie between the others': several steps, by the transition as text."""
    problem = Problem("pen24", 6, 2)
    arrays = problem_arrays(problem, solved_windows(problem, 2))
    assert len(np.unique(arrays["step_s"].round(6))) > 1
    which = arrays["step_index"]
    np.testing.assert_array_equal(arrays["step_s"][which], np.diff(arrays["time_s"], axis=1))
    states, noises = arrays["solution_states"], arrays["solution_noises"]
    f, away = (
        ca.Function.deserialize(str(arrays[f"casadi_{name}"])) for name in ("f", "difference")
    )
    for x, w, steps in zip(states, noises, arrays["step_s"][which], strict=True):
        reached = f(x[:-1].T, w.T, steps[None, :])
        np.testing.assert_allclose(away(x[1:].T, reached), 0, rtol=0, atol=1e-7)
    assert not {"F", "G"} & set(arrays)  # a free pen's transition is not linear
    missing = np.isnan(arrays["y"]).any(axis=2)
    np.testing.assert_array_equal(missing, ~arrays["present"].all(axis=2))


def test_a_linear_transition_is_written_as_matrices() -> None:
    problem = Problem("pen15", 6, 2)
    arrays = problem_arrays(problem, solved_windows(problem, 2))
    which = arrays["step_index"]
    states, noises = arrays["solution_states"], arrays["solution_noises"]
    F, G = arrays["F"][which], arrays["G"][which]
    reached = np.einsum("ikab,ikb->ika", F, states[:, :-1])
    reached += np.einsum("ikab,ikb->ika", G, noises)
    np.testing.assert_allclose(states[:, 1:], reached, rtol=0, atol=1e-7)


def test_bounds_are_in_the_file_and_hold_in_its_solutions(tmp_path: Path) -> None:
    problem = Problem("pen15", 10, 2, bounded=True)
    path = write_problem(problem, problem_arrays(problem, solved_windows(problem, 2)), tmp_path)
    assert path == tmp_path / "problem_pen15_10_bounded.npz"
    stored, computed = speed_problem.costs_of_solutions(path)
    np.testing.assert_allclose(computed, stored, rtol=1e-9)
    with np.load(path) as file:
        states, std = file["solution_states"], file["newest_std"][:, None]
        above, below = (states - file["lower"]) / std, (file["upper"] - states) / std
        bounded = file["state_names"][np.isfinite(file["lower"]) | np.isfinite(file["upper"])]
    assert set(bounded) == set(problem.body.bounds)
    assert min(above.min(), below.min()) > -1e-6
    active = np.minimum(above, below) < 1e-6
    assert (active.sum(axis=(1, 2)) >= 2).all()


def test_the_docs_describe_every_array() -> None:
    text, sensors = DOCS.read_text("utf-8"), {"accel", "gyro", "camera"}
    for name in BODIES:
        problem = Problem(name, 2, 1)
        for array in problem_arrays(problem, solved_windows(problem, 1)):
            sensor, _, field = array.partition("_")
            described = f"`<sensor>_{field}`" if sensor in sensors else f"`{array}`"
            assert described in text, array
