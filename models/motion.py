"""How a pen moves, as data: a chain for its tip and one for its attitude, see `models.chains`.

    [motion.tip]
    chain = "bounded_velocity"
    speed_m_s = 0.08
    correlation_time_s = 0.1
    [motion.attitude]
    chain = "white_jerk"
    jerk_density_rad_s3_per_sqrt_hz = 40.0

A pen file of pen-mhe 0.1 has ``[process_noise]`` in its place: white jerk for both.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PositiveFloat

from models.chains import Chain, bounded_velocity, matern, white_jerk
from models.config import UnitConfig
from models.sensor_kinds.mounted import Vector3


class TipWhiteJerk(UnitConfig):
    """Nothing but its noise drives the tip: it stays neither slow nor near.

    Larger follows faster strokes and smooths less.
    """

    centre_m: ClassVar[Vector3] = (0.0, 0.0, 0.0)
    chain: Literal["white_jerk"] = "white_jerk"
    jerk_density_m_s3_per_sqrt_hz: PositiveFloat = 100.0

    def built(self) -> Chain:
        """Return the chain of one axis."""
        return white_jerk(self.jerk_density_m_s3_per_sqrt_hz)


class TipBoundedVelocity(UnitConfig):
    """A hand that neither accelerates for ever nor gets fast.

    Parameters
    ----------
    speed_m_s : standard deviation of the velocity along an axis; larger follows faster strokes
    correlation_time_s : larger keeps a velocity longer, and smooths more
    """

    centre_m: ClassVar[Vector3] = (0.0, 0.0, 0.0)
    chain: Literal["bounded_velocity"] = "bounded_velocity"
    speed_m_s: PositiveFloat
    correlation_time_s: PositiveFloat

    def built(self) -> Chain:
        """Return the chain of one axis."""
        return bounded_velocity(self.speed_m_s, self.correlation_time_s)


class TipMatern(UnitConfig):
    """A tip that stays near a place.

    Parameters
    ----------
    std_m : standard deviation of the tip about the centre, along an axis
    correlation_time_s : larger is smoother, and stays away longer
    centre_m : the place
    """

    chain: Literal["matern"] = "matern"
    std_m: PositiveFloat
    correlation_time_s: PositiveFloat
    centre_m: Vector3 = (0.0, 0.0, 0.0)

    def built(self) -> Chain:
        """Return the chain of one axis."""
        return matern(self.std_m, self.correlation_time_s)


class AttitudeWhiteJerk(UnitConfig):
    """Nothing but its noise drives the rate of turning."""

    chain: Literal["white_jerk"] = "white_jerk"
    jerk_density_rad_s3_per_sqrt_hz: PositiveFloat = 1000.0

    def built(self) -> Chain:
        """Return the chain of one axis."""
        return white_jerk(self.jerk_density_rad_s3_per_sqrt_hz)


class AttitudeBoundedRate(UnitConfig):
    """A hand that does not turn faster and faster.

    Parameters
    ----------
    rate_rad_s : standard deviation of the rate about an axis
    correlation_time_s : larger keeps a rate longer, and smooths more
    """

    chain: Literal["bounded_velocity"] = "bounded_velocity"
    rate_rad_s: PositiveFloat
    correlation_time_s: PositiveFloat

    def built(self) -> Chain:
        """Return the chain of one axis."""
        return bounded_velocity(self.rate_rad_s, self.correlation_time_s)


TipMotion = Annotated[TipWhiteJerk | TipBoundedVelocity | TipMatern, Field(discriminator="chain")]
AttitudeMotion = Annotated[AttitudeWhiteJerk | AttitudeBoundedRate, Field(discriminator="chain")]

CHAINS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "tip": ("white_jerk", "bounded_velocity", "matern"),
        "attitude": ("white_jerk", "bounded_velocity"),
    }
)
"""Part of a pen → the names that its ``chain`` may have."""


class Motion(UnitConfig):
    """What drives a pen: a chain for each axis of its tip, and one for each of its attitude.

    Without a word in the file it is a hand that writes or points.
    """

    tip: TipMotion = TipBoundedVelocity(speed_m_s=0.5, correlation_time_s=0.15)
    attitude: AttitudeMotion = AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=200.0)


OLD_KEY = "process_noise"
"""The table of a pen file that `Motion` replaces; read with a warning in 0.2."""


_OLD_PREFIX = {"tip": "tip_", "attitude": "angle_"}
"""Part of a motion → how its keys began in `OLD_KEY`."""


def white_jerk_motion(tip: float, attitude: float) -> Motion:
    """Return white jerk for both, of densities in m/s³ and rad/s³ per √Hz."""
    return Motion(
        tip=TipWhiteJerk(jerk_density_m_s3_per_sqrt_hz=tip),
        attitude=AttitudeWhiteJerk(jerk_density_rad_s3_per_sqrt_hz=attitude),
    )


def with_motion(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return a pen as nested dictionaries whose old ``process_noise`` is a ``motion``.

    Warns with the lines that say the same now.
    """
    renewed = {key: value for key, value in data.items() if key != OLD_KEY}
    if OLD_KEY not in data:
        return renewed
    if "motion" in data:
        raise ValueError("process_noise and motion say the same thing, expected motion alone")
    if not isinstance(data[OLD_KEY], Mapping):
        raise ValueError("process_noise: expected a table, or [motion] in its place")
    jerk: dict[str, dict[str, Any]] = {part: {"chain": "white_jerk"} for part in _OLD_PREFIX}
    for key, value in data[OLD_KEY].items():
        part = next((p for p, prefix in _OLD_PREFIX.items() if key.startswith(prefix)), None)
        if part is None:
            raise ValueError(f"{OLD_KEY}: unknown key {key}; expected [motion] in its place")
        jerk[part][key.removeprefix(_OLD_PREFIX[part])] = value
    renewed["motion"] = jerk
    lines = "".join(
        f"\n[motion.{part}]\n"
        + "\n".join(f"{key} = {_toml(value)}" for key, value in table.items())
        for part, table in renewed["motion"].items()
    )
    warnings.warn(
        f"[process_noise] is read for the last time in pen-mhe 0.2; write in its place{lines}",
        FutureWarning,
        stacklevel=2,
    )
    return renewed


def keys_of_file(keys: Sequence[str], data: Mapping[str, Any]) -> list[str]:
    """Return where a key of a motion (motion, tip, …) stands in the file that said it."""
    if OLD_KEY not in data or "motion" in data or len(keys) < 2:
        return list(keys)
    return [OLD_KEY, *(_OLD_PREFIX[keys[1]] + key for key in keys[2:])]


def _toml(value: Any) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)
