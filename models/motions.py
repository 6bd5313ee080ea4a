"""Motions of a pen with exact derivatives: data in a table, one sampler per kind.

A motion gives the degrees of freedom q(t) and their first two derivatives in
closed form. Motions are rows of ``models/motions.toml``; the table
`MOTION_KINDS` says what a row of a kind holds and how it is sampled. Played
faster by a factor s it is q(s t), with s q̇ and s² q̈.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import ValidationError

from models.arrays import Array
from models.bundled import motion_rows
from models.config import UnitConfig
from models.errors import InputError
from models.handwriting import Handwriting, handwriting
from models.minimum_jerk import MinimumJerk, minimum_jerk
from models.names import expected_one_of, unknown
from models.random_streams import Seed
from models.sigma_lognormal import SigmaLognormal, sigma_lognormal

MotionConfig = MinimumJerk | SigmaLognormal | Handwriting


@dataclass(frozen=True, eq=False)
class SampledMotion:
    """A sampled motion.

    Parameters
    ----------
    name : for people
    time_s : (n,)
    q, q_dot, q_ddot : (n, 6): tip, m, azimuth, elevation, spin, rad, and derivatives
    """

    name: str
    time_s: Array
    q: Array
    q_dot: Array
    q_ddot: Array


@dataclass(frozen=True)
class MotionKind:
    """What a row of the table holds, and how it becomes q, q̇, q̈ at given times."""

    config: type[UnitConfig]
    sample: Callable[[Any, Array, np.random.Generator], tuple[Array, Array, Array]]


MOTION_KINDS: Mapping[str, MotionKind] = MappingProxyType(
    {
        "minimum_jerk": MotionKind(
            MinimumJerk, lambda config, time_s, rng: minimum_jerk(config, time_s)
        ),
        "sigma_lognormal": MotionKind(
            SigmaLognormal, lambda config, time_s, rng: sigma_lognormal(config, time_s)
        ),
        "handwriting": MotionKind(Handwriting, handwriting),
    }
)
"""Kind of a motion → its configuration and its sampler."""


@cache
def motions() -> Mapping[str, MotionConfig]:
    """Return the table of motions, ``models/motions.toml``, by name."""
    return parse_motions(motion_rows(), where="models/motions.toml")


def motion_named(name: str) -> MotionConfig:
    """Return a motion of the table by name; raises `InputError` for an unknown one."""
    if name not in motions():
        raise unknown("motion", name, motions())
    return motions()[name]


def parse_motions(data: Mapping[str, Any], where: str = "motions") -> Mapping[str, MotionConfig]:
    """Validate motions given as nested dictionaries, as in a TOML file.

    Raises
    ------
    InputError
        If a kind is unknown or a key or value is wrong; the message names it.
    """
    return MappingProxyType({name: _parsed(name, row, where) for name, row in data.items()})


def _parsed(name: str, row: Any, where: str) -> Any:
    kind = str(row.get("kind")) if isinstance(row, Mapping) else "no table"
    if kind not in MOTION_KINDS:
        raise InputError(
            f"{where}: motion {name}: kind is {kind}, {expected_one_of(kind, MOTION_KINDS)}"
        )
    try:
        return MOTION_KINDS[kind].config.model_validate(row)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        key = ".".join(str(part) for part in first["loc"]) or "(all keys)"
        missing = first["type"] == "missing"
        message = "is missing" if missing else first["msg"].removeprefix("Value error, ")
        raise InputError(f"{where}: motion {name}: key {key}: {message}") from None


def sample_motion(
    motion: str | MotionConfig,
    time_s: Array,
    *,
    seed: Seed = 0,
    speed: float = 1.0,
) -> SampledMotion:
    """Sample a motion with its exact derivatives.

    Parameters
    ----------
    motion : a name in the table, or a configuration of one of the kinds
    time_s : (n,) sampling instants, s
    seed : of a random motion; one seed is one motion, whatever the instants.
        A generator is drawn from and left advanced
    speed : plays it this many times faster

    Raises
    ------
    InputError
        If the name is unknown or the speed is not positive.
    """
    if not 0 < speed < np.inf:
        raise InputError(f"speed is {speed}, expected a positive factor")
    config = motion_named(motion) if isinstance(motion, str) else motion
    name = motion if isinstance(motion, str) else config.kind
    sample = MOTION_KINDS[config.kind].sample
    q, q_dot, q_ddot = sample(config, speed * time_s, np.random.default_rng(seed))
    return SampledMotion(name, time_s, q, speed * q_dot, speed**2 * q_ddot)
