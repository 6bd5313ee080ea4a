"""Recordings as strangers' loggers write them: a rod turned about its tip by hand-like sines.

Nothing here comes from the project's simulator: attitudes are Euler angles, forces second
differences of the chip's place. A chip sits on the rod's axis, somewhere, mounted somehow.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from estimation.recording import Recording
from models.pen_config import PenConfig
from models.pen_file import load_pen
from recordings.finding import Finding, Severity

Array = NDArray[np.float64]

GRAVITY = 9.81
STEP_S = 1e-3
"""Of differences."""
REFERENCE = load_pen("reference")


def proper_mountings() -> list[Array]:
    """Return the 24 rotations that permute axes."""
    every = (
        np.diag(signs)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    )
    return [M for M in every if np.linalg.det(M) > 0]


@dataclass(frozen=True, eq=False)
class Rod:
    """A recording in the chip's axes, and what is true of it.

    Parameters
    ----------
    time_s : (n,)
    force, rate : (n, 3)
    mounting : (3, 3) sensor_to_body of both
    place_m : of the chip, above the tip
    noise : standard deviations of force and rate
    rng : for what is done to it later
    remedy : what a finding has to propose against what was done to it
    """

    time_s: Array
    force: Array
    rate: Array
    mounting: Array
    place_m: float
    noise: tuple[float, float]
    rng: np.random.Generator
    remedy: str = ""

    def pen(self, mounting: Array | None = None) -> PenConfig:
        """Return a pen with this chip, as its owner would write it: noise known to a factor."""
        M = self.mounting if mounting is None else mounting
        rows = tuple(map(tuple, M.tolist()))
        changed = {}
        for name, noise in zip(("accel", "gyro"), self.noise, strict=True):
            sensor = REFERENCE.sensors[name]
            told = noise * float(np.exp(self.rng.normal(0, 0.3)))
            density = sensor.field_beginning("noise_density_")  # type: ignore[attr-defined]
            scale = told / sensor.sample_std  # type: ignore[attr-defined]
            changed[name] = sensor.model_copy(
                update={
                    "sensor_to_body": rows,
                    "position_m": (0.0, 0.0, self.place_m),
                    density: getattr(sensor, density) * scale,
                }
            )
        return REFERENCE.model_copy(update={"sensors": changed})

    def recording(self) -> Recording:
        """Return it as a recording."""
        sensors = {"accel": (self.time_s, self.force), "gyro": (self.time_s, self.rate)}
        return Recording.from_sensors("rod", sensors)


def turned_rod(seed: int) -> Rod:
    """Return a recording of a random rod: rate, mounting, place, noise and biases are drawn."""
    rng = np.random.default_rng(seed)
    rate_hz = float(np.exp(rng.uniform(np.log(20), np.log(1000))))
    still_s, moving_s = rng.uniform(1, 3), rng.uniform(8, 15)
    time_s = np.arange(0, still_s + moving_s, 1 / rate_hz)
    centres = np.radians([rng.uniform(-180, 180), rng.uniform(40, 65), rng.uniform(-180, 180)])
    spreads = np.radians([rng.uniform(8, 25), rng.uniform(5, 12), rng.uniform(8, 30)])
    waves = [
        (spread * rng.uniform(0.5, 1) / k, rng.uniform(0.25, 0.6) * k, rng.uniform(0, 2 * np.pi))
        for spread in spreads
        for k in (1, 2)
    ]

    def attitude(t: Array) -> Rotation:
        on = np.clip((t - still_s) / 1.0, 0, 1)
        on = on**3 * (10 - 15 * on + 6 * on**2)
        azimuth, elevation, spin = (
            centres[i]
            + on * sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in waves[2 * i : 2 * i + 2])
            for i in range(3)
        )
        tilt = np.pi / 2 - elevation
        return Rotation.from_euler("ZYZ", np.column_stack([azimuth, tilt, spin]))

    place = float(rng.uniform(0.03, 0.14))
    before, here, after = attitude(time_s - STEP_S), attitude(time_s), attitude(time_s + STEP_S)
    rate = (before.inv() * after).as_rotvec() / (2 * STEP_S)
    chip = [one.apply([0.0, 0.0, place]) for one in (before, here, after)]
    moved = (chip[0] - 2 * chip[1] + chip[2]) / STEP_S**2
    force = here.inv().apply(moved + np.array([0.0, 0.0, GRAVITY]))
    mounting = proper_mountings()[rng.integers(24)]
    noise = (
        float(np.exp(rng.uniform(np.log(0.006), np.log(0.08)))),
        float(np.radians(np.exp(rng.uniform(np.log(0.03), np.log(0.3))))),
    )
    biases = rng.normal(0, 0.12, 3), np.radians(rng.normal(0, 1.2, 3))
    read = [
        values @ mounting + bias + rng.normal(0, std, values.shape)
        for values, bias, std in zip((force, rate), biases, noise, strict=True)
    ]
    return Rod(time_s, read[0], read[1], mounting, place, noise, rng)


def accelerometer_flipped(rod: Rod) -> Rod:
    """Turn all signs of the accelerometer."""
    return replace(rod, force=-rod.force, remedy="accel=-accel_x,-accel_y,-accel_z")


def gyroscope_flipped(rod: Rod) -> Rod:
    """Turn all signs of the gyroscope."""
    return replace(rod, rate=-rod.rate, remedy="gyro=-gyro_x,-gyro_y,-gyro_z")


def gyroscope_axis_flipped(rod: Rod) -> Rod:
    """Turn the sign of one axis of the gyroscope."""
    signs = np.ones(3)
    signs[rod.rng.integers(3)] = -1
    columns = ",".join(f"{'-' if s < 0 else ''}gyro_{a}" for s, a in zip(signs, "xyz", strict=True))
    return replace(rod, rate=rod.rate * signs, remedy=f"gyro={columns}")


def gyroscope_axes_swapped(rod: Rod) -> Rod:
    """Swap two axes of the gyroscope."""
    order = np.delete(np.arange(3), k := int(rod.rng.integers(3)))[::-1]
    order = np.insert(order, k, k)
    columns = ",".join(f"gyro_{'xyz'[i]}" for i in order)
    return replace(rod, rate=rod.rate[:, order], remedy=f"gyro={columns}")


def accelerometer_axis_flipped(rod: Rod) -> Rod:
    """Turn the sign of one axis of the accelerometer."""
    signs = np.ones(3)
    signs[rod.rng.integers(3)] = -1
    axes = ", ".join(f"{'-' if s < 0 else ''}{a}" for s, a in zip(signs, "xyz", strict=True))
    return replace(rod, force=rod.force * signs, remedy=f"({axes}) of what it reads")


def accelerometer_stuck(rod: Rod) -> Rod:
    """Repeat one reading of the accelerometer from somewhere on."""
    force = rod.force.copy()
    at = int(len(force) * rod.rng.uniform(0.3, 0.8))
    force[at:] = force[at]
    return replace(rod, force=force)


def gyroscope_stuck(rod: Rod) -> Rod:
    """Repeat one reading of the gyroscope for a while."""
    rate = rod.rate.copy()
    n = len(rate)
    at = int(n * rod.rng.uniform(0.3, 0.5))
    rate[at : at + n // 3] = rate[at]
    return replace(rod, rate=rate)


def without_gravity(rod: Rod) -> Rod:
    """Take gravity out, as a phone does: by its own attitude, a degree wrong."""
    t, rate = rod.time_s, rod.rate - np.median(rod.rate[rod.time_s < 0.9], axis=0)
    up = np.median(rod.force[t < 0.9], axis=0)
    up = Rotation.from_rotvec(np.radians(rod.rng.normal(0, 0.6, 3))).apply(up)
    gravity = np.empty_like(rod.force)
    for k, dt in enumerate(np.diff(t, prepend=t[0])):
        up = Rotation.from_rotvec(-rate[k] * dt).apply(up)
        gravity[k] = up
    return replace(rod, force=rod.force - gravity)


def in_milliseconds(rod: Rod) -> Rod:
    """Give times in milliseconds for seconds."""
    return replace(rod, time_s=1e3 * rod.time_s, remedy="time=ms")


def force_in_g(rod: Rod) -> Rod:
    """Give forces in g for m/s²."""
    return replace(rod, force=rod.force / 9.80665, remedy="accel=g")


def rate_in_degrees(rod: Rod) -> Rod:
    """Give rates in deg/s for rad/s."""
    return replace(rod, rate=np.degrees(rod.rate), remedy="gyro=deg_s")


def as_it_is(rod: Rod) -> Rod:
    """Return it unchanged; its pen file is wrong."""
    axis = ", ".join(f"{x + 0.0:g}" for x in rod.mounting[2])
    return replace(rod, remedy=f"[{axis}]]")


@dataclass(frozen=True)
class Kind:
    """What is wrong with a recording.

    Parameters
    ----------
    done : what is done to it
    named : checks of which the first finding has to be
    where : sensor that it has to name
    mounts_wrongly : whether the pen file has another mounting, with another axis
    """

    done: Callable[[Rod], Rod]
    named: str
    where: str
    mounts_wrongly: bool = False


KINDS: Mapping[str, Kind] = {
    "accelerometer flipped": Kind(accelerometer_flipped, "mounting", "accel"),
    "gyroscope flipped": Kind(gyroscope_flipped, "handedness", "gyro"),
    "gyroscope axis flipped": Kind(gyroscope_axis_flipped, "handedness", "gyro"),
    "gyroscope axes swapped": Kind(gyroscope_axes_swapped, "handedness", "gyro"),
    "accelerometer axis flipped": Kind(accelerometer_axis_flipped, "handedness", "accel"),
    "accelerometer stuck": Kind(accelerometer_stuck, "stuck", "accel"),
    "gyroscope stuck": Kind(gyroscope_stuck, "stuck", "gyro"),
    "no gravity": Kind(without_gravity, "missing gravity", "accel"),
    "milliseconds": Kind(in_milliseconds, "time unit", "times"),
    "force in g": Kind(force_in_g, "units", "accel"),
    "rate in deg/s": Kind(rate_in_degrees, "units", "gyro"),
    "mounted otherwise": Kind(as_it_is, "mounting", "accel", mounts_wrongly=True),
}
"""What strangers' files have wrong, a row each."""


def is_named(kind: Kind, rod: Rod, findings: Sequence[Finding]) -> bool:
    """Return whether the first finding names what is wrong, where, and what to do."""
    if not findings:
        return False
    first = findings[0]
    return (
        first.severity is Severity.NOT_MEANT
        and first.check == kind.named
        and kind.where in f"{first.where} {first.what} {first.remedy}"
        and rod.remedy in first.remedy
    )


def wrong_rod(kind: Kind, seed: int) -> tuple[Rod, PenConfig]:
    """Return a recording with something wrong, and the pen of its owner."""
    rod = turned_rod(seed)
    told = rod.mounting
    if kind.mounts_wrongly:
        others = [M for M in proper_mountings() if abs(M[2] @ told[2] - 1) > 0.5]
        told = others[rod.rng.integers(len(others))]
    return kind.done(rod), rod.pen(told)
