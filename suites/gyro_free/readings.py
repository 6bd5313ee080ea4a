"""What two accelerometers on the axis read along a motion: equations (5)-(6), bias and noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.arrays import Array
from models.random_streams import seed_sequence, stream
from suites.gyro_free.gesture import GestureMotion

GRAVITY_M_S2 = 9.81
G_M_S2 = GRAVITY_M_S2
"""The paper states its errors in g."""


@dataclass(frozen=True)
class Errors:
    """Errors of the difference of the two readings, per axis.

    Parameters
    ----------
    bias_m_s2 : size of the constant error. In each axis one of the two accelerometers,
        drawn, has the whole of it, with a drawn sign
    noise_m_s2 : standard deviation of the random part of a sample, white; each accelerometer
        has its √½
    """

    bias_m_s2: float = 1e-4 * G_M_S2
    noise_m_s2: float = 1e-5 * G_M_S2

    @property
    def single_bias_std(self) -> float:
        """Standard deviation of the bias of one accelerometer, m/s²."""
        return self.bias_m_s2 / np.sqrt(2)

    @property
    def single_noise_std(self) -> float:
        """Standard deviation of the noise of one accelerometer, m/s²."""
        return self.noise_m_s2 / np.sqrt(2)


def exact_readings(motion: GestureMotion, half_distance_m: float) -> tuple[Array, Array]:
    """Return f₁, f₂ (n, 3), m/s², at -l and +l on the x axis."""
    gravity = np.array([0.0, 0.0, -GRAVITY_M_S2])
    at_centre = np.einsum("kij,kj->ki", motion.C, motion.acceleration - gravity)

    def at(x: float) -> Array:
        L = np.array([x, 0.0, 0.0])
        centripetal = np.cross(motion.rate, np.cross(motion.rate, L))
        return np.asarray(at_centre + np.cross(motion.rate_derivative, L) + centripetal)

    return at(-half_distance_m), at(half_distance_m)


def readings(
    motion: GestureMotion, half_distance_m: float, errors: Errors, seed: int
) -> tuple[Array, Array]:
    """Return the readings (n, 3) of both accelerometers, with their errors.

    The draws of a seed are the same whatever the errors' sizes and the distance.
    """
    f1, f2 = exact_readings(motion, half_distance_m)
    root = seed_sequence(seed)
    of_bias, of_noise = stream(root, "bias"), stream(root, "noise")
    bias = errors.bias_m_s2 * of_bias.choice([-1.0, 1.0], 3)
    in_second = of_bias.random(3) < 0.5
    noise = errors.single_noise_std * of_noise.standard_normal((2, *f1.shape))
    return f1 + np.where(in_second, 0.0, bias) + noise[0], f2 + np.where(
        in_second, bias, 0
    ) + noise[1]
