"""The problems of ``classics.toml``, one row each."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

import casadi as ca
import numpy as np

from models.arrays import Array
from models.names import unknown
from suites.classics import rates
from suites.classics.problem import ClassicProblem, Noise
from suites.classics.rates import Figures

FILE = Path(__file__).with_name("classics.toml")
NOT_NEGATIVE = (0.0, None)
PLAIN = MappingProxyType({"y": ""})
"""A reading without a unit."""


@cache
def figures_of(case: str) -> Figures:
    """Return the figures of a problem as the file has them."""
    return MappingProxyType(tomllib.loads(FILE.read_text("utf-8"))[case])


def _per_step(given: Figures) -> Noise:
    n = len(given["q"])
    return Noise.of(n, 0, behind=np.array(given["q"]) / np.sqrt(given["dt_s"]))


def _discs_prior(given: Figures) -> tuple[Array, Array]:
    theta, other = given["theta_1_prior"], given["other_prior"]
    mean, std = (np.full(9, other[name]) for name in ("mean", "std"))
    mean[-1], std[-1] = theta["mean"], theta["std"]
    return mean, std


def _discs_truth(given: Figures, rng: np.random.Generator) -> Array:
    others = given["other_truth"] * rng.uniform(-1, 1, 8)
    return np.append(others, given["theta_1_true"])


def _set_points(given: Figures, time_s: Array, rng: np.random.Generator) -> Array:
    """Return two set-points (n, 2): zero at first, both new with probability 0.2 a step."""
    changed, drawn = rng.random(len(time_s)) < 0.2, rng.uniform(-0.8, 0.8, (len(time_s), 2))
    points = np.zeros((len(time_s), 2))
    for k in range(1, len(time_s)):
        points[k] = drawn[k] if changed[k] else points[k - 1]
    return points


def _discs_bounds(given: Figures) -> dict[str, tuple[float | None, float | None]]:
    low, high = given["theta_1_prior"]["bounds"]
    rate = given["rate_bounds_rad_s"]
    return {"theta_1": (low, high)} | {f"dphi_{i}": (-rate, rate) for i in (1, 2, 3)}


def _pendulum_prior(given: Figures) -> tuple[Array, Array]:
    others, length = given["prior"], given["prior_length_m"]
    std = np.full(5, others["std"])
    std[-1] = length["std"]
    return np.append(others["mean"], length["mean"]), std


PROBLEMS: Mapping[str, ClassicProblem] = MappingProxyType(
    {
        "gas_2A_to_B": ClassicProblem(
            title="2A → B",
            states={"pa": "", "pb": ""},
            axes=PLAIN,
            rate=rates.two_a_to_b,
            reads=lambda x, given: x[0] + x[1],
            noise=_per_step,
            bounds=lambda given: dict.fromkeys(("pa", "pb"), NOT_NEGATIVE),
            judged="pa",
            label="P_A (units of pressure)",
            from_s=5.0,
            succeeds_below=lambda given: 0.2,
        ),
        "gas_A_B_C": ClassicProblem(
            title="A ⇌ B + C, 2B ⇌ C",
            states=dict.fromkeys("abc", ""),
            axes=PLAIN,
            rate=rates.a_b_c,
            reads=lambda x, given: given["RT"] * (x[0] + x[1] + x[2]),
            noise=_per_step,
            bounds=lambda given: dict.fromkeys("abc", NOT_NEGATIVE),
            judged="c",
            label="c (units of concentration)",
            from_s=15.0,
            succeeds_below=lambda given: 0.01,
        ),
        "van_der_pol": ClassicProblem(
            title="van der Pol's oscillator",
            states={"x": "", "v": "1/s", "mu": ""},
            axes=PLAIN,
            rate=rates.van_der_pol,
            reads=lambda x, given: x[0],
            noise=lambda given: Noise.of(3, 0, behind=given["q_per_sqrt_s"]),
            judged="mu",
            label="μ (1)",
            from_s=7.5,
        ),
        "rotating_masses": ClassicProblem(
            title="rotating masses",
            states={
                **{f"phi_{i}": "rad" for i in (1, 2, 3)},
                **{f"dphi_{i}": "rad/s" for i in (1, 2, 3)},
                **{f"motor_{i}": "rad" for i in (1, 2)},
                "theta_1": "kg m²",
            },
            axes={f"phi_{i}": "rad" for i in (1, 2, 3)},
            inputs={f"set_point_{i}": "rad" for i in (1, 2)},
            rate=rates.rotating_masses,
            reads=lambda x, given: x[:3],
            noise=lambda given: Noise.of(9, 2, on_inputs=1e-2 / np.sqrt(20)),
            prior=_discs_prior,
            bounds=_discs_bounds,
            # A motor's lag is a tenth of a sample.
            substeps=10,
            truth=_discs_truth,
            signals=_set_points,
            is_within_bounds=True,
            judged="theta_1",
            label="θ₁ (kg m²)",
            from_s=6.0,
            succeeds_below=lambda given: 0.01 * float(given["theta_1_true"]),
        ),
        "pendulum_on_cart": ClassicProblem(
            title="pendulum on a cart",
            states={"x": "m", "theta": "rad", "v": "m/s", "omega": "rad/s", "length": "m"},
            axes={"x": "m", "theta": "rad", "v": "m/s", "omega": "rad/s"},
            inputs={"force": "N"},
            rate=rates.pendulum_on_cart,
            reads=lambda x, given: x[:4],
            noise=lambda given: Noise.of(
                5, 1, on_rates=[*1 / np.sqrt(10 * np.array([0.2, 0.2, 2, 2])), 1.0]
            ),
            prior=_pendulum_prior,
            truth=lambda given, rng: np.append(given["truth"], given["length_m"]),
            kept=("length",),
            signals=lambda given, time_s, rng: (40 * np.sin(2 * np.pi * time_s) * np.exp(-time_s))[
                :, None
            ],
            judged="length",
            label="rod length (m)",
            from_s=2.5,
        ),
        "damped_spring": ClassicProblem(
            title="damped spring",
            states={"x": "m", "v": "m/s"},
            axes={"x": "m"},
            inputs={"force": "N"},
            rate=rates.damped_spring,
            reads=lambda x, given: x[0],
            noise=lambda given: Noise.of(2, 1, on_rates=[0.0, given["w"]]),
            prior=lambda given: (np.array(given["truth"]), np.full(2, 0.01)),
            is_prior_drawn=True,
            signals=lambda given, time_s, rng: np.where(
                np.arange(len(time_s)) < len(time_s) // 2, np.cos(time_s), 0.0
            )[:, None],
            judged="x",
            label="x (m)",
            from_s=0.0,
            is_linear=True,
        ),
        "tank": ClassicProblem(
            title="nearly empty tank",
            states={"x": ""},
            axes=PLAIN,
            rate=rates.at_rest,
            reads=lambda x, given: ca.sqrt(x[0]),
            noise=lambda given: Noise.of(1, 0, behind=0.02),
            bounds=lambda given: {"x": (1e-4, None)},
            judged="x",
            label="x (units of level)",
            from_s=0.0,
            is_reflected=True,
        ),
    }
)
"""Case → problem."""


def problem_named(case: str) -> ClassicProblem:
    """Return a problem; raises `InputError` for an unknown case."""
    if case not in PROBLEMS:
        raise unknown("case", case, PROBLEMS)
    return PROBLEMS[case]
