"""The problems of ``classics.toml`` as models, and their recordings.

States have no unit of the product's table yet: their names end in ``_m`` for the amount that the
problem counts, whatever that is.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import casadi as ca
import numpy as np

from estimation.recording import Recording, Truth
from models.arrays import Array
from models.differential import ode
from models.names import unknown
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.random_streams import seed_sequence, stream
from models.state_space import StateSpaceModel
from suites.classics.rates import (
    Figures,
    Rate,
    a_b_c,
    at_rest,
    two_a_to_b,
    van_der_pol,
)

FILE = Path(__file__).with_name("classics.toml")
SENSOR, AXIS = "reading", "y"


@cache
def figures_of(case: str) -> Figures:
    """Return the figures of a problem as the file has them."""
    return MappingProxyType(tomllib.loads(FILE.read_text("utf-8"))[case])


@dataclass(frozen=True)
class ClassicProblem:
    """What the file says in words, as functions.

    Parameters
    ----------
    states : names of the components, without units
    rate : ẋ
    reads : (x, figures) → the reading
    noise : figures → (n_x,) standard deviations
    per_step : whether the noise is one of a step of dt, or one per √s
    lower : bound of every state that the moving-horizon estimators obey; None for none
    judged : the state of which the suite speaks
    from_s : from when on it is judged
    label : of its axis, with its unit
    reflected : whether the truth turns back at the bound, beyond which there is no reading
    """

    states: tuple[str, ...]
    rate: Rate
    reads: Callable[[ca.SX, Figures], ca.SX]
    noise: Callable[[Figures], list[float]]
    per_step: bool
    lower: float | None
    judged: str
    from_s: float
    label: str
    reflected: bool = False

    def transition(self, given: Figures) -> Callable[[ca.SX, ca.SX, ca.SX], ca.SX]:
        """Return (x, w, Δt) → the next x. The noise of a step grows as √Δt between samples."""
        scale = ca.DM(self.noise(given)) / (np.sqrt(given["dt_s"]) if self.per_step else 1)

        follow = ode(lambda x, w: self.rate(x, given))

        def moved(x: ca.SX, w: ca.SX, dt: ca.SX) -> ca.SX:
            return follow(x, w, dt) + ca.sqrt(dt) * scale * w

        return moved


PROBLEMS: Mapping[str, ClassicProblem] = MappingProxyType(
    {
        "gas_2A_to_B": ClassicProblem(
            states=("pa", "pb"),
            rate=two_a_to_b,
            reads=lambda x, given: x[0] + x[1],
            noise=lambda given: given["q"],
            per_step=True,
            lower=0.0,
            judged="pa",
            from_s=5.0,
            label="P_A (units of pressure)",
        ),
        "gas_A_B_C": ClassicProblem(
            states=("a", "b", "c"),
            rate=a_b_c,
            reads=lambda x, given: given["RT"] * (x[0] + x[1] + x[2]),
            noise=lambda given: given["q"],
            per_step=True,
            lower=0.0,
            judged="c",
            from_s=15.0,
            label="c (units of concentration)",
        ),
        "van_der_pol": ClassicProblem(
            states=("x", "v", "mu"),
            rate=van_der_pol,
            reads=lambda x, given: x[0],
            noise=lambda given: given["q_per_sqrt_s"],
            per_step=False,
            lower=None,
            judged="mu",
            from_s=7.5,
            label="μ (1)",
        ),
        "tank": ClassicProblem(
            states=("x",),
            rate=at_rest,
            reads=lambda x, given: ca.sqrt(x[0]),
            noise=lambda given: [0.02],
            per_step=False,
            lower=1e-4,
            judged="x",
            from_s=0.0,
            label="x (units of level)",
            reflected=True,
        ),
    }
)
"""Case → problem."""


def problem_named(case: str) -> ClassicProblem:
    """Return a problem; raises `InputError` for an unknown case."""
    if case not in PROBLEMS:
        raise unknown("case", case, PROBLEMS)
    return PROBLEMS[case]


@cache
def model_of(case: str) -> StateSpaceModel:
    """Return the model that every contender reads."""
    problem, given = problem_named(case), figures_of(case)
    mean, std = (np.atleast_1d(given["prior"][name]) for name in ("mean", "std"))
    names = [f"{name}_m" for name in problem.states]
    known = {name: (float(m), float(s)) for name, m, s in zip(names, mean, std, strict=True)}
    sensor = OwnSensor(
        lambda x: problem.reads(x, given), {AXIS: "m"}, given["r"], 1 / given["dt_s"]
    )
    bounds = None if problem.lower is None else dict.fromkeys(names, (problem.lower, None))
    return own_model(
        case.replace("_", " "),
        known,
        problem.transition(given),
        len(names),
        {SENSOR: sensor},
        bounds=bounds,
    )


def recorded(case: str, seed: int) -> Recording:
    """Draw a truth from the model's noise, and its readings."""
    problem, given, model = problem_named(case), figures_of(case), model_of(case)
    n = given["samples"]
    w = _drawn(seed, f"motion of {case}", (n - 1, model.n_w))
    v = _drawn(seed, f"readings of {case}", (n,))
    states = np.empty((n, model.n_x))
    states[0] = given["truth"]
    for k in range(n - 1):
        states[k + 1] = model.f(states[k], w[k], given["dt_s"]).full().ravel()
        if problem.reflected and problem.lower is not None:
            states[k + 1] = problem.lower + np.abs(states[k + 1] - problem.lower)
    time_s = given["dt_s"] * np.arange(n)
    exact = np.array([float(model.sensors[0].h(state)) for state in states])
    readings = (exact + given["r"] * v)[:, None]
    return Recording(
        f"{case} {seed}", time_s, {SENSOR: readings}, Truth(time_s, model.state_names, states)
    )


def _drawn(seed: int, purpose: str, shape: tuple[int, ...]) -> Array:
    return np.asarray(stream(seed_sequence(seed), purpose).standard_normal(shape))


def settings(case: str) -> dict[str, Any]:
    """Return what is set of a moving-horizon estimator: N, and nothing else."""
    return {"horizon": int(figures_of(case)["N"])}
