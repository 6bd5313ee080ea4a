"""A swinging arm of known torque, read with a gain that varies: f and h are not linear."""

from __future__ import annotations

import casadi as ca
import numpy as np

from estimation.recording import Recording
from models.own_models import own_model
from models.own_sensors import OwnSensor
from models.state_space import StateSpaceModel
from recordings.simulate_pen import simulate_model


def lamp() -> StateSpaceModel:
    def transition(x: ca.SX, w: ca.SX, dt: ca.SX, u: ca.SX) -> ca.SX:
        pull = u[0] - 9.0 * ca.sin(x[0]) - 0.3 * x[1]
        return ca.vertcat(x[0] + dt * x[1], x[1] + dt * pull + 0.5 * ca.sqrt(dt) * w[0])

    states = {"angle_rad": (0.4, 0.3), "rate_rad_s": (0.0, 0.5)}
    sensors = {
        "shadow": OwnSensor(lambda x, u: u[1] * ca.sin(x[0]), {"x": "m"}, 0.01, 20.0),
        "turns": OwnSensor(lambda x, i=1: x[i], {"z": "rad/s"}, 0.2, 10.0),
    }
    inputs = {"torque": "N m", "gain": ""}
    return own_model("lamp", states, transition, 1, sensors, inputs=inputs, interpolated=["torque"])


def swung() -> Recording:
    """Return a recording whose gain is told at every fifth instant only, and held."""
    signals = {"torque": lambda t: 3 * np.sin(4 * t), "gain": 0.7}
    found = simulate_model(lamp(), duration_s=2.0, seed=1, inputs=signals)
    gain = np.where(np.arange(len(found.time_s)) % 5 == 0, 0.7, np.nan)
    return Recording(
        "swing", found.time_s, found.readings, found.truth, {**found.inputs, "gain": gain}
    )
