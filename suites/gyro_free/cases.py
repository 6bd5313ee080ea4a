"""The cases of the suite as data: which gesture, which sensors, which estimators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from benchmark.configurations import BENCHMARK_ESTIMATORS
from benchmark.from_mhe import REFERENCE
from classical_baseline.differentiators import DIFFERENTIATORS
from classical_baseline.gyro_free import Compensation
from suites.gyro_free.gesture import GestureConfig
from suites.gyro_free.readings import Errors

INTEGRATED, COMPENSATED = "gyro-free-integrated", "gyro-free"
CLASSICAL: Mapping[str, Compensation | None] = MappingProxyType(
    {
        INTEGRATED: None,
        COMPENSATED: Compensation(),
        **{
            f"gyro-free-{name}": Compensation(DIFFERENTIATORS[key])
            for name, key in (
                ("backward", "backward"),
                ("central", "central"),  # looks 1 sample ahead
                ("31-points", "savitzky-golay-31"),
                ("centred", "savitzky-golay-centred"),  # looks 7 samples ahead
            )
        },
        "gyro-free-bold": Compensation(least_determinant=0.2, greatest_condition=200.0),
        "gyro-free-strict": Compensation(least_determinant=20.0, greatest_condition=5.0),
        "gyro-free-gentle": Compensation(gain=0.05),
        # A sample of c has 3 rad/s² of noise on the real array. What (13)-(16) make of it is
        # worth having from 0.3 rad/s on, that is, from this determinant.
        "gyro-free-careful": Compensation(least_determinant=650.0),
    }
)
"""Estimator → its compensation; None integrates only."""

LOOKS_AHEAD = tuple(
    name for name, row in CLASSICAL.items() if row is not None and row.differentiator.ahead
)
"""Estimators that use measurements that have not arrived yet: no choice, a bound."""

MODEL_BASED = tuple(reversed(BENCHMARK_ESTIMATORS))
"""Estimators with the pen model, the slow ones first."""

SLOW_FIRST = (REFERENCE, *MODEL_BASED)

TWO_ACCELS, NO_ROLL, NO_SPIN = "two accels", "two accels, no roll", "two accels, no spin"


@dataclass(frozen=True)
class GyroFreeConfiguration:
    """What the pen model has, beside two accelerometers.

    Parameters
    ----------
    degrees_of_freedom : 6, or 5 for a pen of constant spin
    no_roll : told that the rate about the axis is zero, as the integration takes it
    """

    degrees_of_freedom: int = 6
    no_roll: bool = False


CONFIGURATIONS: Mapping[str, GyroFreeConfiguration] = MappingProxyType(
    {
        TWO_ACCELS: GyroFreeConfiguration(),
        NO_ROLL: GyroFreeConfiguration(no_roll=True),
        NO_SPIN: GyroFreeConfiguration(degrees_of_freedom=5),
    }
)
"""Sensors of a task → what the pen model has. Who has no model is listed with `TWO_ACCELS`."""


@dataclass(frozen=True)
class GyroFreeCase:
    """A case.

    Parameters
    ----------
    half_distance_m : l
    noise_factor : larger noise of the readings, in that of the test case
    gesture : how the pen moves
    errors : of the readings at a noise factor of 1
    first_s : begin of the gesture that is run and judged; None: all of it
    classical : names of `CLASSICAL`
    sensors : keys of `CONFIGURATIONS` that `MODEL_BASED` estimators run with
    """

    half_distance_m: float = 0.04
    noise_factor: float = 1.0
    gesture: GestureConfig = field(default_factory=GestureConfig)
    errors: Errors = field(default_factory=Errors)
    first_s: float | None = None
    classical: tuple[str, ...] = (INTEGRATED, COMPENSATED)
    sensors: tuple[str, ...] = (TWO_ACCELS,)

    @property
    def reading_errors(self) -> Errors:
        """The errors of this case's readings."""
        return replace(self.errors, noise_m_s2=self.noise_factor * self.errors.noise_m_s2)


TEST_CASE, BEGIN_S = "test case", 0.5
BEGIN = f"{TEST_CASE}, {BEGIN_S:g} s"
"""What IPOPT solves too."""
_ALL = tuple(name for name in CLASSICAL if name != "gyro-free-careful")
_BOTH = (TWO_ACCELS, NO_ROLL)
CASES: Mapping[str, GyroFreeCase] = MappingProxyType(
    {
        TEST_CASE: GyroFreeCase(classical=_ALL, sensors=tuple(CONFIGURATIONS)),
        BEGIN: GyroFreeCase(first_s=BEGIN_S, classical=(), sensors=()),
        "l 10 mm": GyroFreeCase(half_distance_m=0.01, sensors=_BOTH),
        "l 20 mm": GyroFreeCase(half_distance_m=0.02, sensors=()),
        "l 80 mm": GyroFreeCase(half_distance_m=0.08, sensors=()),
        "l 160 mm": GyroFreeCase(half_distance_m=0.16, sensors=_BOTH),
        "noise x0": GyroFreeCase(noise_factor=0, classical=_ALL, sensors=()),
        "noise x3": GyroFreeCase(noise_factor=3, classical=_ALL, sensors=()),
        "noise x10": GyroFreeCase(noise_factor=10, classical=_ALL, sensors=_BOTH),
        "noise x30": GyroFreeCase(noise_factor=30, classical=_ALL, sensors=()),
        "noise x100": GyroFreeCase(noise_factor=100, classical=_ALL, sensors=_BOTH),
        "roll": GyroFreeCase(gesture=GestureConfig(roll="no spin"), sensors=tuple(CONFIGURATIONS)),
        "one plane": GyroFreeCase(gesture=GestureConfig(turns_hz=0.0), sensors=(NO_ROLL,)),
        "slow": GyroFreeCase(gesture=GestureConfig(rate_rad_s=0.5), sensors=()),
        "fast": GyroFreeCase(gesture=GestureConfig(rate_rad_s=4.0), sensors=()),
        "no bias": GyroFreeCase(errors=Errors(bias_m_s2=0.0), sensors=()),
    }
)
"""Name → case: the paper's numbers, and what they become one change at a time."""


@dataclass(frozen=True)
class ArrayCase:
    """A case of the real array.

    Parameters
    ----------
    pairs : (lower, upper) sensors, counted from 0; a task takes all of them together
    part : of the recording, a key of `array_pairs.PARTS`
    model_based : whether estimators with the pen model run, too
    """

    pairs: tuple[tuple[int, int], ...]
    part: str = "turns"
    model_based: bool = True


# Along x and along y, on top and on the underside.
_EDGES = ((0, 4), (2, 0), (3, 7), (7, 5))
_DIAGONALS = ((0, 6), (2, 4), (1, 7), (3, 5))
ARRAY_CASES: Mapping[str, ArrayCase] = MappingProxyType(
    {
        "array edge": ArrayCase(_EDGES),
        "array diagonal": ArrayCase(_DIAGONALS),
        "array edge, between knocks": ArrayCase(_EDGES, "between knocks"),
        "array diagonal, between knocks": ArrayCase(_DIAGONALS, "between knocks"),
        # Shaken at 2000 deg/s a board soon turns through an upright pen, where the model's
        # angles are singular, and its attitude is not known at the start.
        "array edge, shaken": ArrayCase(_EDGES, "shaken", model_based=False),
        "array diagonal, shaken": ArrayCase(_DIAGONALS, "shaken", model_based=False),
    }
)
"""Name → case of the real array. A seed is one segment of the recording."""

ARRAY_CLASSICAL = (INTEGRATED, COMPENSATED, "gyro-free-careful", "gyro-free-gentle")
