"""What still poses said of one sensor: numbers to read, and values for its pen file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from models.sensor_kinds.inertial import InertialSensor, sample_noise_std
from models.sensor_model import quantiser_variance
from models.units import shown
from pen_mhe.calibration.allan import NoiseLevels
from pen_mhe.calibration.length import N_BIAS, PARAMETERS, LengthFit
from pen_mhe.calibration.rate import RateFit
from pen_mhe.tuning.parameters import SENSORS, Parameter


@dataclass(frozen=True)
class CalibratedNumber:
    """One number that was found.

    Parameters
    ----------
    sensor, quantity, unit : for people
    value, std : in that unit
    """

    sensor: str
    quantity: str
    unit: str
    value: float
    std: float


@dataclass(frozen=True, eq=False)
class CalibratedSensor:
    """What was found of one sensor, in SI.

    Parameters
    ----------
    sensor : as the pen file has it
    gravity, rate, noise : None where that was not looked for, or the sensor does not have it
    rate_hz : samples per second
    """

    name: str
    sensor: InertialSensor
    gravity: LengthFit | None
    rate: RateFit | None
    noise: NoiseLevels | None
    rate_hz: float

    @cached_property
    def density(self) -> tuple[float, float] | None:
        """Value and deviation of the pen file's noise density; None below the resolution.

        The one of which a sample has the white noise N √rate, beside its resolution.
        """
        if self.noise is None:
            return None
        N, N_std = self.noise.density
        drawn = N**2 * self.rate_hz - quantiser_variance(self.sensor.resolution)
        if drawn <= 0:
            return None
        density = math.sqrt(drawn) / sample_noise_std(1.0, self.sensor.bandwidth_hz)
        return density, density * N * N_std * self.rate_hz / drawn

    @property
    def bias_std(self) -> float | None:
        """What the bias is known to at another instant and pose, the least known axis."""
        instability = 0.0
        if self.noise is not None and self.noise.instability is not None:
            instability = self.noise.instability[0]
        if self.gravity is not None:
            std, spread = self.gravity.std[:N_BIAS].max(), self.gravity.misfit_std
        elif self.rate is not None:
            worst = int(np.argmax(np.hypot(self.rate.std, self.rate.spread_std)))
            std, spread = self.rate.std[worst], self.rate.spread_std[worst]
        else:
            return None
        return float(np.sqrt(std**2 + spread**2 + instability**2))

    def numbers(self) -> Iterator[CalibratedNumber]:
        """Yield what was found, in units that people read."""
        _, unit, factor = shown(f"bias_{self.sensor.si_unit}")

        def number(quantity: str, value: float, std: float, per: str = "") -> CalibratedNumber:
            return CalibratedNumber(
                self.name, quantity, f"{unit}{per}", factor * value, factor * std
            )

        if self.gravity is not None:
            found = zip(PARAMETERS, self.gravity.values, self.gravity.std, strict=False)
            for i, (quantity, value, std) in enumerate(found):
                if i < N_BIAS:
                    yield number(quantity, float(value), float(std))
                else:
                    is_scale = quantity.startswith("scale")
                    yield CalibratedNumber(
                        self.name, quantity, "" if is_scale else "rad",
                        float(value) + is_scale, float(std),
                    )  # fmt: skip
        if self.rate is not None:
            for axis, value, std in zip(
                self.sensor.axes, self.rate.bias, self.rate.std, strict=True
            ):
                yield number(f"bias {axis}", float(value), float(std))
        if self.density is not None:
            yield number("noise density", *self.density, per="/√Hz")
        if self.noise is not None and self.noise.instability is not None:
            yield number("bias instability", *self.noise.instability)
        if self.noise is not None and self.noise.walk is not None:
            yield number("bias walk", *self.noise.walk, per="/√s")

    def values(self) -> dict[Parameter, Any]:
        """Return what a pen file is told."""
        sensor, found = self.sensor, dict[str, Any]()
        has_state = bool(sensor.bias_states(self.name).names)
        if self.gravity is not None:
            found[f"bias_{sensor.si_unit}"] = tuple(map(float, self.gravity.bias))
            if self.gravity.count > N_BIAS:
                rows = self.gravity.sensitivity.tolist()
                found["sensitivity"] = tuple(tuple(row) for row in rows)
        if self.rate is not None:
            known: dict[str, float] = dict(
                zip(sensor.axes, map(float, self.rate.bias), strict=True)
            )
            bias = zip("xyz", sensor.bias, strict=True)
            found[f"bias_{sensor.si_unit}"] = tuple(known.get(axis, old) for axis, old in bias)
        if has_state and self.bias_std is not None:
            found[sensor.field_beginning("bias_std_")] = self.bias_std
        if self.density is not None:
            found[sensor.field_beginning("noise_density_")] = self.density[0]
        if has_state and self.noise is not None and self.noise.walk is not None:
            found[sensor.field_beginning("bias_walk_")] = self.noise.walk[0]
        return {Parameter("still", (SENSORS, self.name), key): v for key, v in found.items()}

    def sentences(self) -> Iterator[str]:
        """Yield what a person should know."""
        if self.gravity is not None:
            fit = self.gravity
            before, after = (float(np.sqrt(np.mean(r**2))) for r in (fit.before, fit.after))
            said = (
                f"{self.name}: |f| is off gravity by {before:.3g} m/s² before, {after:.3g} after "
                f"(RMS over {len(fit.after)} stretches; noise alone: {fit.expected_std:.3g})"
            )
            if fit.inflation > 1:
                said += f": deviations are {fit.inflation:.3g} times those of noise"
            yield said
        if self.rate is not None:
            _, unit, factor = shown(f"bias_{self.sensor.si_unit}")
            spread = factor * float(self.rate.spread_std.max())
            yield (
                f"{self.name}: its bias differs between stretches by {spread:.3g} {unit} "
                "beyond noise"
            )
        if self.noise is not None:
            missing = [
                word
                for word, level in (("instability", self.noise.instability),
                                    ("walk", self.noise.walk))
                if level is None
            ]  # fmt: skip
            if missing:
                yield (
                    f"{self.name}: the bias' {' and '.join(missing)} "
                    f"{'is' if len(missing) == 1 else 'are'} not determined: "
                    f"clusters of up to {self.noise.longest_s:.3g} s do not show "
                    f"{'it' if len(missing) == 1 else 'them'}, expected a still stretch of an hour"
                )
        if self.noise is not None and self.density is None:
            yield f"{self.name}: its noise is below its resolution, and is left as it is"
