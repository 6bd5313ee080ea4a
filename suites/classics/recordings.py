"""The problems as models, and what is drawn of them: the same for every contender."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.gaussian import GaussianState
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from suites.classics.problems import figures_of, problem_named

SENSOR = "reading"


@cache
def model_of(case: str) -> StateSpaceModel:
    """Return the model that every estimator reads."""
    problem, given = problem_named(case), figures_of(case)
    mean, std = problem.prior(given)
    known = {
        name: (float(m), float(s)) for name, m, s in zip(problem.states, mean, std, strict=True)
    }
    sensor = OwnSensor(
        lambda x: problem.reads(x, given), problem.axes, given["r"], 1 / given["dt_s"]
    )
    return own_model(
        case.replace("_", " "),
        known,
        problem.transition(given),
        problem.noise(given).n_w,
        {SENSOR: sensor},
        bounds=problem.bounds(given),
        units=problem.states,
        inputs=problem.inputs,
    )


def recorded(case: str, seed: int) -> Recording:
    """Draw a truth from the model's noise, and its readings.

    An input that is known with noise acts as it is; the recording has what is known of it.
    """
    problem, given, model = problem_named(case), figures_of(case), model_of(case)
    time_s = given["dt_s"] * np.arange(given["samples"])
    streams = {purpose: _stream(case, seed, purpose) for purpose in ("inputs", "start", "motion")}
    states, known = _moved(case, time_s, streams)
    while problem.is_within_bounds and not _obey(model, states):
        states, known = _moved(case, time_s, streams)
    v = _stream(case, seed, "readings").standard_normal((len(time_s), model.n_y))
    exact = np.array([model.sensors[0].h(state).full().ravel() for state in states])
    return Recording(
        f"{case} {seed}",
        time_s,
        {SENSOR: exact + np.asarray(given["r"]) * v},
        Truth(time_s, model.state_names, states),
        dict(zip(problem.inputs, known.T, strict=True)),
    )


def _moved(
    case: str, time_s: Array, streams: Mapping[str, np.random.Generator]
) -> tuple[Array, Array]:
    """Draw true states (n, n_x), and what is known of the inputs (n, n_u)."""
    problem, given, model = problem_named(case), figures_of(case), model_of(case)
    known = problem.signals(given, time_s, streams["inputs"])
    w = streams["motion"].standard_normal((len(time_s) - 1, model.n_w))
    errors = problem.noise(given).factors()[2]
    known[:-1] -= w[:, model.n_w - errors.shape[1] :] @ errors.T
    for state in problem.kept:
        w[:, _noise_of(case, state)] = 0
    states = np.empty((len(time_s), model.n_x))
    states[0] = problem.truth(given, streams["start"])
    for k, noise in enumerate(w):
        ends = (known[k], known[k + 1]) if model.n_u else ()
        states[k + 1] = model.f(states[k], noise, given["dt_s"], *ends).full().ravel()
        if problem.is_reflected:
            states[k + 1] = model.lower + np.abs(states[k + 1] - model.lower)
    return states, known


def _obey(model: StateSpaceModel, states: Array) -> bool:
    return bool(((model.lower <= states) & (states <= model.upper)).all())


def _noise_of(case: str, state: str) -> Array:
    """Return which unit noises (n_w,) move a state's rate."""
    problem = problem_named(case)
    behind, rates, inputs = problem.noise(figures_of(case)).factors()
    row = list(problem.states).index(state)
    return np.concatenate([behind[row] != 0, rates[row] != 0, np.zeros(inputs.shape[1], bool)])


def prior_of(case: str, recording: Recording, seed: int) -> GaussianState:
    """Return what the estimators start from: the model's prior, or one drawn about the truth."""
    prior = model_of(case).prior
    if not problem_named(case).is_prior_drawn:
        return prior
    assert recording.truth is not None
    away = np.sqrt(np.diag(prior.covariance)) * _stream(case, seed, "prior").standard_normal(
        len(prior.mean)
    )
    return GaussianState(recording.truth.values[0] + away, prior.covariance)


def _stream(case: str, seed: int, purpose: str) -> np.random.Generator:
    return stream(seed_sequence(seed), f"{purpose} of {case}")


def settings(case: str) -> dict[str, Any]:
    """Return what is set of a moving-horizon estimator: N, and nothing else."""
    return {"horizon": int(figures_of(case)["N"])}
