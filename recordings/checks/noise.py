"""Check: is a resting sensor as noisy as the pen file says?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from models.units import readable_unit
from recordings.checks.looked import Looked
from recordings.finding import Finding

LOUDER, QUIETER = 4.0, 15.0
"""Times by which noise at rest is above, or below, that of the pen file. A file whose noise also
stands for a pen that scratches over paper is several times above that at rest."""


def check_noise(looked: Looked) -> Iterator[Finding]:
    """Find sensors whose noise at rest is far from the pen file's."""
    for name, at_rest in looked.noise.items():
        sensor = looked.inertial[name]
        seen, told = float(np.sqrt(np.mean(at_rest**2))), sensor.sample_std
        if told / QUIETER < seen < LOUDER * told:
            continue
        times = f"{seen / told:.2g} times" if seen > told else f"1/{told / max(seen, 1e-12):.3g} of"
        unit = readable_unit(sensor.si_unit)
        density = sensor.field_beginning("noise_density_")
        yield Finding(
            f"at rest its noise is {seen:.3g} {unit}, {times} the {told:.3g} {unit} of the file",
            name,
            0.9,
            f"pen-mhe calibrate still finds it, pen-mhe tune what fits the motion; in the pen file "
            f"{density} is now {getattr(sensor, density):.3g}",
        )
