"""A sensor of rest for a pen whose file has none, where a recording of it is seen to be still.

Without one a gyroscope's bias about the vertical does not show at rest, and turns into tilt as soon
as the pen leans another way.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from estimation.recording import Recording
from models.pen_config import PenConfig
from models.sensor_kinds.rest import Rest
from pen_mhe.no_pen.at_rest import at_rest, inertial_of

NAME = "rest"
SPREAD = 2.5
"""Times the noise that is seen at rest that a reading may spread by; larger takes trembling for
rest."""


def with_rest(
    pen: PenConfig, recording: Recording, *, sensors: Collection[str] | None = None
) -> tuple[PenConfig, tuple[str, ...]]:
    """Return a pen with a sensor of rest where it has none and a recording begins to need one.

    Parameters
    ----------
    recording : whole, or its first part
    sensors : names of those that are used; None takes all

    Returns
    -------
    The pen, and a sentence where it is another
    """
    used = recording.readings if sensors is None else sensors
    names = [name for name in recording.readings if name in used]
    inertial = inertial_of(pen, names)
    turns = any(sensor.reads_rate for sensor in inertial.values())
    feels = any(sensor.feels_gravity for sensor in inertial.values())
    if not (turns and feels) or any(sensor.is_rest for sensor in pen.sensors.values()):
        return pen, ()
    rest = at_rest(recording, inertial)
    if rest is None or NAME in pen.sensors:
        return pen, ()
    seen = max(
        float((rest.noise_std(name) / sensor.sample_std).max()) for name, sensor in inertial.items()
    )
    if SPREAD * seen <= 1:  # by the file's noise a hand would rest
        return pen, ()
    sensor = Rest(spread_factor=float(np.round(SPREAD * max(seen, 1.0), 2)))
    note = (
        f"rest: the recording is still for {rest.duration_s:.2g} s and the pen file has no sensor "
        "of rest: one is added, which finds the gyroscope's bias (--no-rest goes without)"
    )
    return pen.model_copy(update={"sensors": {**pen.sensors, NAME: sensor}}), (note,)
