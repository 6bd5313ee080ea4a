"""A model for people: its states with their prior, its sensors with their noise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from models.gaussian import GaussianState
from models.sensor_model import SensorModel, noise_text


def model_text(
    title: str, state_names: Iterable[str], prior: GaussianState, sensors: Iterable[SensorModel]
) -> str:
    """Return a line for the title, each state and each sensor."""
    lines = [title]
    for name, mean, std in zip(state_names, prior.mean, prior.std, strict=True):
        lines.append(f"  {name:32s} prior {mean:10.4g} ± {std:.4g}")
    for sensor in sensors:
        rate = f"{sensor.rate_hz:g} Hz" if sensor.rate_hz else "as recorded"
        lines.append(f"  {sensor.name} ({sensor.kind}, {rate}): noise {noise_text(sensor)}")
    return "\n".join(lines)


def model_html(
    title: str, states: Mapping[str, str], prior: GaussianState, sensors: Iterable[SensorModel]
) -> str:
    """Return two tables for a notebook.

    Parameters
    ----------
    states : name → unit
    """
    of_states = "".join(
        f"<tr><td>{name}</td><td>{unit}</td><td>{mean:.4g} ± {std:.4g}</td></tr>"
        for (name, unit), mean, std in zip(states.items(), prior.mean, prior.std, strict=True)
    )
    of_sensors = "".join(
        f"<tr><td>{sensor.name}</td><td>{sensor.kind}</td><td>{noise_text(sensor)}</td></tr>"
        for sensor in sensors
    )
    return (
        f"<b>{title}</b><table><tr><th>state</th><th>unit</th><th>prior</th></tr>{of_states}"
        f"</table><table><tr><th>sensor</th><th>kind</th><th>noise (std)</th></tr>{of_sensors}"
        "</table>"
    )
