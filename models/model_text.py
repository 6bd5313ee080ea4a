"""A model for people: what they read of it, with its prior, and its sensors with their noise."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Protocol

import casadi as ca
import numpy as np

from models.gaussian import GaussianState
from models.outputs import Outputs
from models.sensor_model import SensorModel, noise_text


class ReadModel(Protocol):
    """What is told of a model; see `models.state_space.StateSpaceModel`."""

    @property
    def name(self) -> str:
        """For people."""

    @property
    def state_names(self) -> tuple[str, ...]:
        """(n_x,)"""

    @property
    def state_units(self) -> tuple[str, ...]:
        """(n_x,)"""

    @property
    def prior(self) -> GaussianState:
        """Of the states."""

    @property
    def sensors(self) -> tuple[SensorModel, ...]:
        """In the order of their readings."""

    @property
    def retract(self) -> ca.Function:
        """Of the states' manifold."""

    @property
    def outputs(self) -> Outputs | None:
        """None where people read the states."""

    @property
    def input_names(self) -> tuple[str, ...]:
        """(n_u,)"""

    @property
    def input_units(self) -> tuple[str, ...]:
        """(n_u,)"""

    @property
    def n_w(self) -> int:
        """Number of noises."""


def _prior_rows(model: ReadModel) -> Iterator[tuple[str, str, float, float]]:
    """Yield name, unit, prior mean and standard deviation of what people read."""
    outputs, prior = model.outputs, model.prior
    if outputs is None:
        yield from zip(model.state_names, model.state_units, prior.mean, prior.std, strict=True)
        return
    x = ca.SX.sym("x", len(model.state_names))
    J = ca.Function("J", [x], [ca.densify(outputs.jacobian(model.retract, x))])(prior.mean).full()
    mean = outputs.function(prior.mean).full().ravel()
    std = np.sqrt(((J @ prior.covariance) * J).sum(axis=1))
    yield from zip(outputs.names, outputs.units, mean, std, strict=True)


def model_text(model: ReadModel) -> str:
    """Return a line for the title, each output and each sensor."""
    n_x = len(model.state_names)
    lines = [f"StateSpaceModel {model.name}: {n_x} states, {model.n_w} noises"]
    for name, unit, mean, std in _prior_rows(model):
        lines.append(f"  {name:32s} prior {mean:10.4g} ± {std:.4g} {unit}".rstrip())
    for name, unit in zip(model.input_names, model.input_units, strict=True):
        lines.append(f"  {name:32s} known input{f', {unit}' if unit else ''}")
    for sensor in model.sensors:
        rate = f"{sensor.rate_hz:g} Hz" if sensor.rate_hz else "as recorded"
        lines.append(f"  {sensor.name} ({sensor.kind}, {rate}): noise {noise_text(sensor)}")
    return "\n".join(lines)


def model_html(model: ReadModel) -> str:
    """Return two tables for a notebook."""
    of_states = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(unit)}</td><td>{mean:.4g} ± {std:.4g}</td></tr>"
        for name, unit, mean, std in _prior_rows(model)
    )
    of_sensors = "".join(
        f"<tr><td>{escape(sensor.name)}</td><td>{sensor.kind}</td><td>{escape(noise_text(sensor))}</td></tr>"
        for sensor in model.sensors
    )
    return (
        f"<b>{escape(model.name)}</b><table><tr><th>state</th><th>unit</th><th>prior</th></tr>{of_states}"
        f"</table><table><tr><th>sensor</th><th>kind</th><th>noise (std)</th></tr>{of_sensors}"
        "</table>"
    )
