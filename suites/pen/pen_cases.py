"""The whole pen in the suite `pen`: how it moves, and what its estimator takes it for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from benchmark.configurations import BENCHMARK_ESTIMATORS, CONFIGURATIONS
from models.gentle_hand import BY_SPEED
from models.pen_config import PenConfig, Prior, ProcessNoise
from models.pen_file import load_pen

PEN_ESTIMATORS = BENCHMARK_ESTIMATORS
MOTION, DURATION_S = "handwriting", 4.0

BOTH = ("accel+gyro",)


@dataclass(frozen=True)
class PenCase:
    """A case.

    Parameters
    ----------
    about : what it shows, for people
    sensors : keys of `benchmark.configurations.CONFIGURATIONS`
    speed : at which the handwriting is played; process noise and prior follow it
    degrees_of_freedom : of the pen that moves
    assumed : degrees of freedom of the estimator's pen
    neglects : the estimator takes the accelerometer for one at the tip of a pen whose tip
        does not accelerate, so that it shows gravity and nothing else: what [Pen] does with
        its turntable
    """

    about: str
    sensors: tuple[str, ...]
    speed: float = 1.0
    degrees_of_freedom: int = 5
    assumed: int = 5
    neglects: bool = False


REFERENCE, WITH_SPIN = "reference pen, handwriting", "reference pen with spin"

PEN_CASES: Mapping[str, PenCase] = MappingProxyType(
    {
        REFERENCE: PenCase("handwriting without spin", tuple(CONFIGURATIONS)),
        WITH_SPIN: PenCase(
            "handwriting with spin", tuple(CONFIGURATIONS), degrees_of_freedom=6, assumed=6
        ),
        "spin ignored": PenCase(
            "a pen that spins, taken for one that does not",
            ("accel+gyro", "accel+gyro+camera"),
            degrees_of_freedom=6,
        ),
        **{
            f"rigid body, speed {speed:g}": PenCase(
                "the same handwriting at another speed", BOTH, speed
            )
            for speed in (0.1, 0.3, 3.0)
        },
        **{
            f"accelerations neglected, speed {speed:g}": PenCase(
                "the accelerometer taken for gravity alone", BOTH, speed, neglects=True
            )
            for speed in (0.1, 0.3, 1.0, 3.0)
        },
    }
)
"""Name → case."""

NEGLIGIBLE = 1e-3
"""Factor of the tip's motion where its accelerations are neglected."""


@cache
def moving_pen(case: str) -> PenConfig:
    """Return the pen that moves in a case."""
    return _fit(PEN_CASES[case].degrees_of_freedom, PEN_CASES[case].speed)


@cache
def assumed_pen(case: str) -> PenConfig:
    """Return the pen that the estimator of a case assumes."""
    row = PEN_CASES[case]
    pen = _fit(row.assumed, row.speed)
    return _neglecting(pen) if row.neglects else pen


def _fit(degrees_of_freedom: int, speed: float) -> PenConfig:
    """Return the reference pen, its prior and process noise fit for handwriting at a speed."""
    pen = load_pen("reference")
    fitted = {
        part: {name: value * speed**exponent for name, (value, exponent) in row.items()}
        for part, row in BY_SPEED.items()
    }
    return pen.model_copy(
        update={
            "degrees_of_freedom": degrees_of_freedom,
            "prior": Prior.model_validate({**pen.prior.model_dump(), **fitted["prior"]}),
            "process_noise": ProcessNoise.model_validate(fitted["process_noise"]),
        }
    )


def _neglecting(pen: PenConfig) -> PenConfig:
    """Return a pen whose accelerometer sits at a tip that hardly accelerates."""
    prior, noise = pen.prior, pen.process_noise
    sensors = {
        name: sensor.model_copy(update={"position_m": (0.0, 0.0, 0.0)})
        if sensor.is_mounted
        else sensor
        for name, sensor in pen.sensors.items()
    }
    return pen.model_copy(
        update={
            "prior": prior.model_copy(
                update={
                    "velocity_std_m_s": NEGLIGIBLE * prior.velocity_std_m_s,
                    "acceleration_std_m_s2": NEGLIGIBLE * prior.acceleration_std_m_s2,
                }
            ),
            "process_noise": noise.model_copy(
                update={
                    "tip_jerk_density_m_s3_per_sqrt_hz": NEGLIGIBLE
                    * noise.tip_jerk_density_m_s3_per_sqrt_hz
                }
            ),
            "sensors": MappingProxyType(sensors),
        }
    )
