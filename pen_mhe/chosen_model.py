"""The model of a run: a pen with those of its sensors that the run takes of a recording."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from models.errors import InputError
from models.pen import pen_model
from models.pen_config import PenConfig
from models.state_space import StateSpaceModel


def chosen_model(
    pen: PenConfig,
    recorded: Collection[str],
    *,
    sensors: Sequence[str] | None = None,
    writing_area: bool = True,
    rest: bool = True,
) -> StateSpaceModel:
    """Return the model of a pen with some sensors.

    Parameters
    ----------
    recorded : names of the sensors that a recording has readings of
    sensors, writing_area, rest : see `pen_mhe.estimate_run.estimate_recording`

    Raises
    ------
    InputError
        If no chosen sensor has readings of its own.
    """
    chosen = tuple(sensors or (name for name in pen.sensors if name in recorded))
    if rest:
        pen, chosen = _with_told_rest(pen, recorded, chosen)
    elif sensors is None:
        chosen = tuple(name for name in chosen if not pen.sensors[name].is_rest)
    model = pen_model(pen, chosen, writing_area=writing_area, rest=rest)
    if not model.measured_sensors:
        raise InputError(
            f"sensors {', '.join(s.name for s in model.sensors)} have no readings of their own, "
            "expected at least one that has"
        )
    return model


def _with_told_rest(
    pen: PenConfig, recorded: Collection[str], sensors: Sequence[str]
) -> tuple[PenConfig, tuple[str, ...]]:
    """Return pen and sensors with rest as the recording tells it; as they are where it does not.

    The pen's sensor of rest is then read instead of detected, and goes with any gyroscope.
    """
    told = {
        name: sensor.model_copy(update={"is_detected": False})
        for name, sensor in pen.sensors.items()
        if sensor.makes_readings and name in recorded
    }
    has_rate = any(pen.sensors[name].reads_rate for name in sensors if name in pen.sensors)
    more = [name for name in told if has_rate and name not in sensors]
    return pen.model_copy(update={"sensors": {**pen.sensors, **told}}), (*sensors, *more)
