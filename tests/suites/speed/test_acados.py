"""acados as a contender: absent by name, or one iteration that is everyone's Gauss-Newton step."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from estimation import native
from suites.speed.acados_contender import Acados, acados_parameters
from suites.speed.acados_library import FOLDER, acados_library
from suites.speed.acados_settings import ACADOS, ACADOS_TUNED, TRIED
from suites.speed.clock import OWN_WALL_CLOCK, THREAD_CLOCK
from suites.speed.contender import ONE_PASS, PASS_CALL, ContenderAbsentError, Entry
from suites.speed.osqp_contender import TUNED_BOUNDED, Osqp
from suites.speed.problems import Problem
from suites.speed.runner import built, race
from suites.speed.windows import SpeedWindow, solved_windows

EXACT = {**TUNED_BOUNDED, "eps_abs": 1e-9, "eps_rel": 1e-9, "rho": 30.0, "max_iter": 400_000}
STEP_STD = 1e-6
"""Without bounds one factorisation is the whole step."""
BARRIER_STD = 1e-3
"""With bounds HPIPM's fastest mode stops some 1e-4 away."""

PROBLEMS = (
    Problem("pen15", 10, 3),
    Problem("pen24", 6, 2),
    Problem("pen15", 10, 3, bounded=True),
    Problem("pen24", 6, 2, seed=2, bounded=True),
)


def test_without_acados_it_is_left_out_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder in ("", str(tmp_path)):
        monkeypatch.setenv(FOLDER, folder)
        with pytest.raises(ContenderAbsentError, match=r"^acados is not installed \(PEN_MHE"):
            acados_library()


def test_without_a_compiler_it_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, interpreted: None
) -> None:
    (tmp_path / "acados").mkdir()
    monkeypatch.setenv(FOLDER, str(tmp_path))
    with pytest.raises(ContenderAbsentError, match="acados needs a C compiler"):
        acados_library()


def test_what_is_raced_was_tried() -> None:
    assert {ACADOS, ACADOS_TUNED} <= set(TRIED)
    assert len(set(map(str, TRIED))) == len(TRIED)
    assert all(settings.levenberg == 0 for settings in TRIED)  # another step otherwise


def test_parameters_say_what_a_stage_needs() -> None:
    problem = Problem("turntable", 4, 1)
    (solved,) = solved_windows(problem, 1)
    window = solved.window
    first, *_, last = acados_parameters(window)
    n_x = window.model.n_x
    prior = np.concatenate([window.prior.mean, window.prior_factor_inverse.ravel(order="F")])
    np.testing.assert_array_equal(first[-len(prior) :], prior)
    assert not last[-len(prior) :].any()
    np.testing.assert_array_equal(last[:n_x], window.guess.states[-1])
    assert len(first) == len(last)


def needs_acados() -> None:
    try:
        acados_library()
    except ContenderAbsentError as reason:
        pytest.skip(str(reason))


@pytest.mark.slow
@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: problem.key)
def test_one_iteration_is_one_gauss_newton_step(problem: Problem) -> None:
    needs_acados()
    solved = solved_windows(problem, problem.windows)
    windows, model = [each.window for each in solved], solved[0].window.model
    exact = partial(Osqp, settings=EXACT, bounded_settings=EXACT)
    entries: list[Entry[SpeedWindow]] = [
        Entry("exact", ONE_PASS, exact),
        *(
            Entry(name, mode, partial(Acados, settings=settings, call_only=mode == PASS_CALL))
            for name, settings in (("acados", ACADOS), ("acados-tuned", ACADOS_TUNED))
            for mode in (ONE_PASS, PASS_CALL)
        ),
    ]
    first, *others = built(entries, model, windows[0], lambda *reason: pytest.fail(str(reason)))
    race([first, *others], windows, warm_up=0)
    for racer in others:
        assert str(racer.contender.version).startswith("comma-deps-acados ")
        clock = THREAD_CLOCK if racer.entry.mode == ONE_PASS else OWN_WALL_CLOCK
        assert {r.clock for turn in racer.turns for r in turn.readings} == {clock}
        assert min(turn.cpu_s.min() for turn in racer.turns) > 1e-6
        for own, step, each in zip(racer.outcomes, first.outcomes, solved, strict=True):
            assert own.solved == 1
            away = model.difference(own.newest, step.newest).full().ravel()
            std = each.optimum.newest.std
            tolerance = BARRIER_STD if problem.bounded else STEP_STD
            assert np.abs(away / std).max() < tolerance, racer.entry.label


@pytest.mark.slow
def test_it_leaves_casadi_and_its_fatrop_alone() -> None:
    """Its package has a CasADi and a BLASFEO of its own, which must not stand in for CasADi's."""
    needs_acados()
    here = ca.__file__
    x = ca.SX.sym("x", 2)
    solver = ca.nlpsol("s", "fatrop", {"x": x, "f": ca.sumsqr(x - 1)}, {"fatrop.print_level": 0})
    np.testing.assert_allclose(np.ravel(solver(x0=0)["x"]), 1, atol=1e-6)
    assert sys.modules["casadi"].__file__ == here
    assert native.compiler() is not None
    fresh = "from suites.speed.acados_library import *; acados_library(); import casadi"
    told = subprocess.run(
        [sys.executable, "-c", f"{fresh}; print(casadi.__file__)"],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert told.stdout.strip() == here
