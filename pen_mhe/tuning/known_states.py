"""A model with numbers as states that are known and never change: one compiled filter for all.

    x = (states, numbers),   f(x, w, Δt) = (f(states, w, Δt; numbers), numbers)

Another choice of the numbers is another first state, not another compilation.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from estimation.outputs import outputs_of
from models.arrays import Array
from models.gaussian import GaussianState
from models.manifold import no_inequality
from models.outputs import Outputs
from models.sensor_model import SensorModel
from models.state_space import StateSpaceModel


def with_known_states(
    base: StateSpaceModel,
    names: tuple[str, ...],
    *,
    f: ca.Function,
    sensors: tuple[SensorModel, ...],
    prior: GaussianState,
    moves: bool = False,
) -> StateSpaceModel:
    """Return a model with k numbers behind its states.

    Parameters
    ----------
    names : (k,) of the numbers
    f, sensors, prior : of the states with the numbers behind them
    moves : whether the tangent space moves the numbers; else no gain knows them
    """
    n, k = base.n_x, len(names)
    x, delta, other = (ca.SX.sym(name, n + k) for name in ("x", "delta", "other"))
    moved = x[n:] + delta[n:] if moves else x[n:]
    away = x[n:] - other[n:] if moves else ca.SX.zeros(k)
    outputs = outputs_of(base)
    nothing: dict[str, Any] = {"symmetries": (), "conditions": None, "tangent": None}
    return base.replace(
        name=f"{base.name}, numbers as states",
        state_names=base.state_names + names,
        state_units=base.state_units + ("",) * k,
        f=f,
        sensors=sensors,
        prior=prior,
        retract=ca.Function(
            "retract", [x, delta], [ca.vertcat(base.retract(x[:n], delta[:n]), moved)]
        ),
        difference=ca.Function(
            "difference", [x, other], [ca.vertcat(base.difference(x[:n], other[:n]), away)]
        ),
        lower=np.full(n + k, -np.inf),
        upper=np.full(n + k, np.inf),
        inequality=no_inequality(n + k),
        regularity=ca.Function("regularity", [x], [base.regularity(x[:n])]),
        reach=None if base.reach is None else np.concatenate([base.reach, np.full(k, np.inf)]),
        outputs=Outputs(
            outputs.names,
            outputs.units,
            ca.Function("outputs", [x], [outputs.function(x[:n])]),
            outputs.wrapped,
        ),
        **nothing,
    )


def known_behind(prior: GaussianState, values: Array, std: Array) -> GaussianState:
    """Return a prior with numbers (k,) behind its states, known to standard deviations (k,)."""
    n = len(prior.mean)
    covariance = np.diag(np.concatenate([np.zeros(n), std**2]))
    covariance[:n, :n] = prior.covariance
    return GaussianState(np.concatenate([prior.mean, values]), covariance)
