"""A problem's windows as one file of arrays: all that another solver needs.

``python -m suites.speed.export FOLDER`` writes ``problem_<key>.npz`` of every problem; every array
is described in docs/speed.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimation.derivatives import Derivatives
from estimation.output_file import whole_file
from estimation.output_folder import check_folder, make_folder
from models.errors import InputError
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel
from suites.speed.problems import PROBLEMS, Problem, find_problem
from suites.speed.races import WARM_UP
from suites.speed.tangent import is_plain
from suites.speed.windows import SolvedWindow, running_on, solved_windows

GEOMETRY = ("position_m", "sensor_to_body")
"""Fields of a mounted sensor that are written as they are."""


def write_problem(problem: Problem, arrays: Mapping[str, NDArray[Any]], folder: Path) -> Path:
    """Write the file of a problem from its `problem_arrays`; return its path."""
    path = folder / f"problem_{problem.key}.npz"
    named: dict[str, Any] = dict(arrays)
    with whole_file(path) as file:
        np.savez_compressed(file, **named)
    return path


def problem_arrays(problem: Problem, solved: Sequence[SolvedWindow]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a problem's file, by name."""
    model = solved[0].window.model
    return {
        **_parameters(problem),
        **_model_arrays(model),
        **_window_arrays(model, solved),
    }


def _parameters(problem: Problem) -> dict[str, NDArray[Any]]:
    """Gravity, degrees of freedom, and where every sensor sits."""
    config = problem.body.config
    arrays: dict[str, Any] = {
        "body": "pen" if isinstance(config, PenConfig) else "turntable",
        "gravity_m_s2": config.gravity_m_s2,
        "sensor_names": list(config.sensors),
        "sensor_kinds": [sensor.kind for sensor in config.sensors.values()],
    }
    if isinstance(config, PenConfig):
        arrays["degrees_of_freedom"] = config.degrees_of_freedom
        arrays["fixed_spin_rad"] = config.fixed_spin_rad
    for name, sensor in config.sensors.items():
        for field in GEOMETRY:
            arrays[f"{name}_{field}"] = getattr(sensor, field)
        if hasattr(sensor, "axes"):
            arrays[f"{name}_axes"] = ["xyz".index(axis) for axis in sensor.axes]
    return {name: np.array(value) for name, value in arrays.items()}


def _model_arrays(model: StateSpaceModel) -> dict[str, NDArray[Any]]:
    """Names, noise and bounds."""
    return {
        "state_names": np.array(model.state_names),
        "reading_names": np.array(model.reading_names),
        "noise_std": model.noise_std,
        "lower": model.lower,
        "upper": model.upper,
        "casadi_f": np.array(model.f.serialize()),
        "casadi_retract": np.array(model.retract.serialize()),
        "casadi_difference": np.array(model.difference.serialize()),
    }


def _window_arrays(
    model: StateSpaceModel, solved: Sequence[SolvedWindow]
) -> dict[str, NDArray[Any]]:
    """Transition, prior, readings, warm start and solution of every window."""
    windows = [each.window for each in solved]
    dt = np.array([window.dt for window in windows])
    steps, which = np.unique(dt, return_inverse=True)
    at = Derivatives(model)
    F, G = zip(*(at.of_step(model.prior.mean, float(step)) for step in steps), strict=True)
    transition = {"F": F, "G": G} if is_plain(model) else {}
    optima = [running_on(model, each.window.prior.mean, each.optimum.trajectory) for each in solved]
    readings = np.array([[m.y for m in window.measurements] for window in windows])
    arrays: Mapping[str, Any] = {
        "step_s": steps,
        **transition,
        "step_index": which.reshape(dt.shape),
        "time_s": [[m.time_s for m in window.measurements] for window in windows],
        "prior_mean": [window.prior.mean for window in windows],
        "prior_covariance": [window.prior.covariance for window in windows],
        "prior_factor": [window.prior_factor for window in windows],
        "y": readings,
        "present": [window.present for window in windows],
        "warm_states": [window.guess.states for window in windows],
        "warm_noises": [window.guess.noises for window in windows],
        "solution_states": [optimum.states for optimum in optima],
        "solution_noises": [optimum.noises for optimum in optima],
        "newest_std": [each.optimum.newest.std for each in solved],
        "cost": [each.optimum.cost for each in solved],
    }
    return {name: np.array(value) for name, value in arrays.items()}


def export(problem: Problem, windows: int, folder: Path) -> Path:
    """Write the file of a problem with the windows that its race times; return its path.

    Parameters
    ----------
    windows : at most so many
    """
    count = WARM_UP + min(windows, problem.windows)
    timed = solved_windows(problem, count)[WARM_UP:]
    return write_problem(problem, problem_arrays(problem, timed), folder)


def main() -> None:
    """Write the files of problems, one after the other."""
    every = [problem.key for problem in PROBLEMS]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="made where it is missing")
    parser.add_argument("--problems", nargs="+", choices=every, default=every, metavar="NAME")
    parser.add_argument("--windows", type=int, default=max(p.windows for p in PROBLEMS))
    given = parser.parse_args()
    if given.windows < 1:
        parser.error(f"--windows is {given.windows}, expected 1 or more")
    try:
        check_folder(given.folder)
        make_folder(given.folder)
        for name in given.problems:
            print(export(find_problem(name), given.windows, given.folder))
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
