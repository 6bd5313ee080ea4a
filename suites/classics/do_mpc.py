"""do-mpc's moving-horizon estimator on a problem, as its documentation has it.

    min ‖x_0 - x̄_0‖²_{P_x} + ‖p - p̄‖²_{P_p} + Σ ‖v_k‖²_{P_v} + ‖w_k‖²_{P_w}

Weights are the file's variances, N is the file's, everything else is its default: Radau
collocation of degree 2 in the model's continuous form, noise on the rates, the arrival cost's
weights fixed at the prior's. A state that nothing changes is a parameter. It has no reading at the
first state, so the first sample's is not used, and it claims no deviations.
"""

from __future__ import annotations

import time
from typing import Any

import casadi as ca
import numpy as np

from estimation.recording import Recording
from models.arrays import Array
from models.gaussian import GaussianState
from suites.classics.contender import Estimates
from suites.classics.problem import ClassicProblem
from suites.classics.problems import figures_of, problem_named
from suites.classics.rates import Figures
from suites.classics.recordings import SENSOR, settings
from suites.peers import in_silence, peer

NAME, MODULE = "do-mpc", "do_mpc"


class DoMpcEstimator:
    """Built once for a problem; every recording begins anew."""

    def __init__(self, case: str) -> None:
        do_mpc, self.version = peer(MODULE, NAME)
        self._problem, given = problem_named(case), figures_of(case)
        with in_silence():
            model, self._constants = _model(do_mpc, self._problem, given)
            self._mhe = _estimator(do_mpc, model, self._problem, given, self._constants)
        self._horizon = settings(case)["horizon"]

    def estimates(self, recording: Recording, prior: GaussianState) -> Estimates:
        """Return what it makes of a recording."""
        mhe, names = self._mhe, list(self._problem.states)
        moving = np.array([name not in self._constants for name in names])
        mhe.reset_history()
        mhe.flags["initial_run"] = False
        mhe.opt_x_num = mhe.opt_x(0)  # nothing of the recording before
        mhe.x0, mhe.u0 = prior.mean[moving], np.zeros(len(recording.inputs))
        if self._constants:
            mhe.p_est0 = prior.mean[~moving]
        mhe.set_initial_guess()
        known = np.array(list(recording.inputs.values())).T
        n = len(recording.time_s)
        mean, solved, took = np.tile(prior.mean, (n, 1)), np.ones(n, bool), np.zeros(n)
        for k in range(1, n):
            y = np.concatenate([recording.readings[SENSOR][k], known[k - 1] if known.size else []])
            begun = time.perf_counter()
            mean[k, moving] = mhe.make_step(y[:, None]).ravel()
            took[k] = time.perf_counter() - begun
            mean[k, ~moving] = mhe.opt_x_num["_p_est"].full().ravel()
            solved[k] = mhe.solver_stats["success"]
        return Estimates(mean, np.full_like(mean, np.nan), solved, took, claims=False)


def _model(do_mpc: Any, problem: ClassicProblem, given: Figures) -> tuple[Any, tuple[str, ...]]:
    """Return the problem as a model of theirs, and its constant states."""
    noise = rate_noise(problem, given)
    symbols = ca.SX.sym("x", len(problem.states)), ca.SX.sym("u", len(problem.inputs))
    rates = problem.rate(*symbols, given)
    constants = tuple(
        name for i, name in enumerate(problem.states) if noise[i] == 0 and ca.SX(rates[i]).is_zero()
    )
    theirs = do_mpc.model.Model("continuous", "SX")
    x = ca.vertcat(
        *(theirs.set_variable("_p" if name in constants else "_x", name) for name in problem.states)
    )
    u = ca.vertcat(*(theirs.set_variable("_u", name) for name in problem.inputs))
    rates = problem.rate(x, u, given)
    for i, name in enumerate(problem.states):
        if name not in constants:
            theirs.set_rhs(name, rates[i], process_noise=bool(noise[i] > 0))
    theirs.set_meas(SENSOR, problem.reads(x, given), meas_noise=True)
    for i, std in enumerate(problem.noise(given).on_inputs):
        theirs.set_meas(f"known_{i}", u[i], meas_noise=bool(std > 0))
    theirs.setup()
    return theirs, constants


def rate_noise(problem: ClassicProblem, given: Figures) -> Array:
    """Return standard deviations (n_x,) of noise on the rates that is held over a step."""
    noise = problem.noise(given)
    return np.hypot(noise.behind / np.sqrt(given["dt_s"]), noise.on_rates)


def _estimator(
    do_mpc: Any, model: Any, problem: ClassicProblem, given: Figures, constants: tuple[str, ...]
) -> Any:
    """Return the estimator, set up."""
    mhe = do_mpc.estimator.MHE(model, list(constants))
    mhe.settings.n_horizon, mhe.settings.t_step = int(given["N"]), given["dt_s"]
    mhe.settings.meas_from_data = True
    mhe.settings.supress_ipopt_output()
    names, noise = list(problem.states), problem.noise(given)
    std = dict(zip(names, problem.prior(given)[1], strict=True))
    readings = np.broadcast_to(given["r"], len(problem.axes))
    of_rates = rate_noise(problem, given)
    mhe.set_default_objective(
        P_x=_weights([std[name] for name in names if name not in constants]),
        P_v=_weights([*readings, *noise.on_inputs[noise.on_inputs > 0]]),
        P_p=_weights([std[name] for name in constants]) if constants else None,
        P_w=_weights(of_rates[of_rates > 0]) if (of_rates > 0).any() else None,
    )
    for name, (low, high) in problem.bounds(given).items():
        kind = "_p_est" if name in constants else "_x"
        if low is not None:
            mhe.bounds["lower", kind, name] = low
        if high is not None:
            mhe.bounds["upper", kind, name] = high
    mhe.setup()
    return mhe


def _weights(stds: Any) -> Array:
    """Return the diagonal matrix of 1 / σ²."""
    return np.diag(1 / np.square(np.asarray(stds, dtype=float)))
