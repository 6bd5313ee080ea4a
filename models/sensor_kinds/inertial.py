"""What accelerometer and gyroscope share: how noisy a sample is."""

from __future__ import annotations

import math

from pydantic import PositiveFloat

from models.sensor_kinds.vector_sensor import VectorSensor
from models.sensor_model import quantiser_variance


def sample_noise_std(density: float, bandwidth_hz: float) -> float:
    """Return the standard deviation of one sample behind a single-pole filter.

    ``σ = density · √(π/2 · bandwidth)``: π/2 is the ratio of the noise
    bandwidth of a single pole to its -3 dB frequency.
    """
    return density * math.sqrt(math.pi / 2 * bandwidth_hz)


class InertialSensor(VectorSensor):
    """Feels how a body moves, in white noise of a density (``noise_density_…``) in each axis.

    Parameters
    ----------
    bandwidth_hz : of the single pole that the noise is behind
    """

    bandwidth_hz: PositiveFloat

    @property
    def sample_std(self) -> float:
        """Standard deviation of a sample by noise and resolution."""
        drawn = sample_noise_std(self.value_beginning("noise_density_"), self.bandwidth_hz)
        return math.sqrt(drawn**2 + quantiser_variance(self.resolution))
