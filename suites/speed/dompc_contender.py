"""do-mpc's moving-horizon estimator on the same window.

Discrete model in SX with additive process noise, weighted by time-varying parameters, as
its documentation has it; the first reading goes into the arrival cost, because do-mpc has
no measurement at the first state. A reading's residual (a rotation, for a camera) is given
as a measurement of zero, its mask as a factor. Solved by `MHE.solve` with the parameters
and the initial guess set by hand: `make_step` does that work in Python at every step.
IPOPT with its default tolerance, ``warm_start_init_point`` and, for bounds, a barrier that
begins at 1e-3; nothing is stored. Bounds are its own, on every state of the window.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from estimation.symbolic_stage import stacked_residual
from mhe.trajectory import Trajectory
from models.state_space import StateSpaceModel
from suites.speed.contender import (
    ContenderAbsentError,
    RaceOutcome,
    in_silence,
    knows_only_bounds,
    peer,
)
from suites.speed.tangent import is_plain
from suites.speed.windows import SpeedWindow

OPTIONS = {
    "calc_lam_p": False,
    "ipopt.warm_start_init_point": "yes",
    "ipopt.mu_init": 1e-3,
}


class DoMpc:
    """A window's NLP as do-mpc writes it down, solved by IPOPT."""

    def __init__(self, model: StateSpaceModel, example: SpeedWindow) -> None:
        do_mpc, self.version = peer("do_mpc", "do-mpc")
        knows_only_bounds(model)
        if not is_plain(model):
            raise ContenderAbsentError("do-mpc adds its noise to the state, an attitude has no sum")
        self._model, self._horizon = model, len(example.dt)
        with in_silence():
            self._mhe = _estimator(do_mpc, model, len(example.dt))
        x, w, dt = ca.SX.sym("x", model.n_x), ca.SX.sym("w", model.n_w), ca.SX.sym("dt")
        G = ca.jacobian(model.f(x, w, dt), w)
        self._noise_factor = ca.Function("G", [x, dt], [ca.substitute(G, w, np.zeros(model.n_w))])

    def prepare(self, item: SpeedWindow) -> None:
        """Write parameters and initial guess; forget the multipliers of the last window."""
        self._window, guess = item, item.guess
        given, start = self._mhe.opt_p_num, self._mhe.opt_x_num
        given["_x_prev"] = item.prior.mean
        given["_p_set", "L_inverse"] = item.prior_factor_inverse.ravel(order="F")
        given["_p_set", "y_first"] = item.y[0]
        given["_p_set", "present_first"] = item.present[0].astype(float)
        start["_v"] = 0
        start["_x", 0, -1] = guess.states[0]
        for k in range(self._horizon):
            given["_tvp", k, "y"] = item.y[k + 1]
            given["_tvp", k, "present"] = item.present[k + 1].astype(float)
            given["_tvp", k, "dt"] = item.dt[k]
            start["_x", k + 1, -1] = guess.states[k + 1]
            start["_w", k] = self._noise_factor(guess.states[k], item.dt[k]) @ guess.noises[k]
        self._mhe.flags["initial_run"] = False

    def solve(self) -> None:
        """Call do-mpc."""
        self._mhe.solve()

    def outcome(self) -> RaceOutcome:
        """Read the solution; unit noises are those whose factor gives the additive ones."""
        found, stages = self._mhe.opt_x_num, range(self._horizon)
        states = np.array([found["_x", k, -1].full().ravel() for k in range(self._horizon + 1)])
        factors = [self._noise_factor(states[k], self._window.dt[k]).full() for k in stages]
        noises = np.array(
            [np.linalg.solve(factors[k], found["_w", k].full().ravel()) for k in stages]
        )
        solved = bool(self._mhe.solver_stats["success"])
        return RaceOutcome(solved, states[-1], Trajectory(states, noises))


def _estimator(do_mpc: Any, model: StateSpaceModel, horizon: int) -> Any:
    """Return the estimator, set up."""
    mhe = do_mpc.estimator.MHE(_model(do_mpc, model), [])
    settings = mhe.settings
    settings.n_horizon, settings.t_step, settings.meas_from_data = horizon, 1.0, False
    settings.store_lagr_multiplier, settings.store_solver_stats = False, []
    settings.supress_ipopt_output()
    settings.nlpsol_opts.update(OPTIONS)
    mhe.set_objective(*_objective(mhe, model))
    mhe.bounds["lower", "_x", "x"], mhe.bounds["upper", "_x", "x"] = model.lower, model.upper
    given = (
        (mhe.set_tvp_fun, mhe.get_tvp_template()),
        (mhe.set_p_fun, mhe.get_p_template()),
        (mhe.set_y_fun, mhe.get_y_template()),
    )
    for set_function, template in given:
        set_function(lambda _, template=template: template)
    mhe.setup()
    return mhe


def _model(do_mpc: Any, model: StateSpaceModel) -> Any:
    """Return x_{k+1} = f(x_k, 0, Δt) + w_k, 0 = present · residual(y, x) / σ + v."""
    theirs = do_mpc.model.Model("discrete", "SX")
    x = theirs.set_variable("_x", "x", shape=(model.n_x, 1))
    y = theirs.set_variable("_tvp", "y", shape=(model.n_y, 1))
    present = theirs.set_variable("_tvp", "present", shape=(model.n_r, 1))
    dt = theirs.set_variable("_tvp", "dt")
    theirs.set_variable("_p", "L_inverse", shape=(model.n_x**2, 1))
    theirs.set_variable("_p", "y_first", shape=(model.n_y, 1))
    theirs.set_variable("_p", "present_first", shape=(model.n_r, 1))
    theirs.set_rhs("x", model.f(x, np.zeros(model.n_w), dt), process_noise=True)
    theirs.set_meas("residual", _whitened(model, present, y, x), meas_noise=True)
    theirs.setup()
    return theirs


def _objective(mhe: Any, model: StateSpaceModel) -> tuple[ca.SX, ca.SX]:
    """Return (stage cost, arrival cost)."""
    x, before, given = mhe._x.cat, mhe._x_prev.cat, mhe._p_set
    unit_w = ca.SX.sym("w", model.n_w)
    reached = model.f(x, unit_w, mhe.model.tvp["dt"])
    G = ca.jacobian(reached, unit_w)
    stage = ca.sumsqr(mhe._v.cat) + ca.sumsqr(ca.solve(G, mhe._w.cat))
    L_inverse = ca.tril(ca.reshape(given["L_inverse"], model.n_x, model.n_x))
    first = _whitened(model, given["present_first"], given["y_first"], x)
    arrival = ca.sumsqr(L_inverse @ (x - before)) + ca.sumsqr(first)
    return stage / 2, arrival / 2


def _whitened(model: StateSpaceModel, present: ca.SX, y: ca.SX, x: ca.SX) -> ca.SX:
    return present * stacked_residual(model, y, x) / model.noise_std
