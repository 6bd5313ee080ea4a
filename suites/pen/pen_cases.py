"""The whole pen in the suite `pen`: how it moves, and what its estimator takes it for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from benchmark.from_mhe import NEAR
from benchmark.from_mhe import REFERENCE as OPTIMUM
from models.pen_config import PenConfig
from suites.pen.told_pens import FREE, FREE_PEN, NO_SPIN, NO_SPIN_PEN, ToldPen, told_pen
from suites.pen_quantities import SETTLING_S

PEN_ESTIMATORS = BENCHMARK_ESTIMATORS
MOTION, DURATION_S = "handwriting", 4.0

WITH_IPOPT_S, WITH_IPOPT_SETTLING_S = 0.5, 0.25
"""Stretch of the recording that IPOPT solves too. An accelerometer alone takes it 45 ms a step
there, but up to 300 iterations and 1.8 s from 0.6 s on."""

BOTH = ("accel+gyro",)


@dataclass(frozen=True)
class PenCase:
    """A case.

    Parameters
    ----------
    about : what it shows, for people
    sensors : keys of `benchmark.configurations.CONFIGURATIONS`
    assumed : the estimator's pen; the handwriting is played at its speed
    degrees_of_freedom : of the pen that moves
    estimators : that run on it
    duration_s, settling_s : of the recording, and its begin that errors leave out
    has_few_seeds : it takes long, see `benchmark.tasks.suite.Scope`
    """

    about: str
    sensors: tuple[str, ...]
    assumed: ToldPen = NO_SPIN_PEN
    degrees_of_freedom: int = NO_SPIN
    estimators: tuple[str, ...] = PEN_ESTIMATORS
    duration_s: float = DURATION_S
    settling_s: float = SETTLING_S
    has_few_seeds: bool = False


REFERENCE, WITHOUT_SPIN = "free pen, handwriting", "no-spin pen, handwriting"
WITH_IPOPT = f"free pen, handwriting, {WITH_IPOPT_S:g} s"
ON_AXIS, PRINTED = "no-spin pen, rigid body", "no-spin pen, (9) as printed"
ON_AXIS_BEGIN, PRINTED_BEGIN = (f"{case}, {WITH_IPOPT_S:g} s" for case in (ON_AXIS, PRINTED))
SPIN_IGNORED, MEASURED_HAND = "spin ignored", "free pen, hand measured"

PEN_CASES: Mapping[str, PenCase] = MappingProxyType(
    {
        REFERENCE: PenCase(
            "a pen that spins", tuple(CONFIGURATIONS), FREE_PEN, FREE,
            estimators=("ukf", *PEN_ESTIMATORS),
        ),
        WITH_IPOPT: PenCase(
            "how far `mhe` is from the optimum", tuple(CONFIGURATIONS), FREE_PEN, FREE,
            estimators=(OPTIMUM, NEAR), duration_s=WITH_IPOPT_S,
            settling_s=WITH_IPOPT_SETTLING_S, has_few_seeds=True,
        ),
        MEASURED_HAND: PenCase(
            "what it is worth to know the hand", BOTH,
            ToldPen(FREE, hand_is_measured=True), FREE, estimators=("ekf",),
        ),
        **{
            case: PenCase(
                "what the errors of (9) cost", (*BOTH, "accel+gyro+camera"),
                ToldPen(is_on_axis=True, is_printed=case == PRINTED),
                estimators=("mhe-rti", "ekf"),
            )
            for case in (ON_AXIS, PRINTED)
        },
        **{
            case: PenCase(
                "the same on the stretch that IPOPT solves too", ("accel+gyro+camera",),
                ToldPen(is_on_axis=True, is_printed=case == PRINTED_BEGIN),
                estimators=(OPTIMUM, NEAR, "mhe-rti", "ekf"), duration_s=WITH_IPOPT_S,
                settling_s=WITH_IPOPT_SETTLING_S, has_few_seeds=True,
            )
            for case in (ON_AXIS_BEGIN, PRINTED_BEGIN)
        },
        SPIN_IGNORED: PenCase(
            "a pen that spins, taken for one that does not",
            ("gyro", "accel+gyro", "accel+gyro+camera"),
            degrees_of_freedom=FREE,
        ),
        WITHOUT_SPIN: PenCase("the paper's pen, which cannot spin", tuple(CONFIGURATIONS)),
        **{
            f"rigid body, speed {speed:g}": PenCase(
                "the same handwriting at another speed", BOTH, ToldPen(speed=speed)
            )
            for speed in (0.1, 0.3, 3.0)
        },
        **{
            f"accelerations neglected, speed {speed:g}": PenCase(
                "the accelerometer taken for gravity alone", BOTH,
                ToldPen(speed=speed, neglects=True),
            )
            for speed in (0.1, 0.3, 1.0, 3.0)
        },
    }
)  # fmt: skip
"""Name → case."""


def moving_pen(case: str) -> PenConfig:
    """Return the pen that moves in a case, told its hand."""
    row = PEN_CASES[case]
    return told_pen(
        replace(
            row.assumed,
            degrees_of_freedom=row.degrees_of_freedom,
            neglects=False,
            is_printed=False,
        )
    )
