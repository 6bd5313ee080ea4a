"""acados: one real-time iteration of a window, as its moving-horizon estimation goes.

States are the steps δ_k of `suites.speed.stagewise`, controls the steps ω_k of the noises;
readings, present rows and the point (x̃, w̃) are parameters, so is the prior's factor at
stage 0:

    min  ½‖r_0 + W δ_0‖² + ½ Σ_k ‖r_k + H_k δ_k‖² + ½ Σ_k ‖w̃_k + ω_k‖²
    s.t. δ_{k+1} = b_k + F_k δ_k + G_k ω_k

The derivatives are those at δ = 0, where the one iteration of SQP_RTI linearises in any case: of
an attitude they are much shorter there. Bounds on states are bounds on δ.
"""

from __future__ import annotations

import tempfile
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from models.arrays import Array
from models.state_space import StateSpaceModel
from suites.speed.acados_library import AcadosLibrary, acados_library, quietly_building
from suites.speed.acados_settings import AcadosSettings
from suites.speed.clock import Counted
from suites.speed.contender import RaceOutcome, in_silence, knows_only_bounds
from suites.speed.gauss_newton_qp import linear_gap, linear_prior, linear_residual
from suites.speed.stagewise import bounded_states, trajectory_of
from suites.speed.windows import SpeedWindow

FLAGS = "-O2 -march=native -fno-math-errno"
"""For its generated C: those of this project, and free to contract, which gains."""
FAR = 1e6
"""What stands for no bound, in standard deviations: this acados knows no infinite one."""
_NUMBER = count()


class Acados:
    """A Gauss-Newton step, by SQP_RTI with partial condensing and HPIPM.

    Parameters
    ----------
    settings : as tried
    call_only : count what acados says of its own call: wall time in whole microseconds
    """

    def __init__(
        self,
        model: StateSpaceModel,
        example: SpeedWindow,
        settings: AcadosSettings,
        call_only: bool = False,
    ) -> None:
        library = acados_library()
        knows_only_bounds(model)
        self.version, self._call_only = f"{library.version}: {settings}", call_only
        self._model, self._N, self._bounded = model, len(example.dt), bounded_states(model)
        self._solver = _solver(model, self._N, settings)

    def prepare(self, item: SpeedWindow) -> None:
        """Write the window into the parameters; the warm start is zero, whatever came before."""
        self._window, N = item, self._N
        self._solver.reset()
        for k, values in enumerate(acados_parameters(item)):
            self._solver.set(k, "p", values)
        for k, x in enumerate(item.guess.states):
            for field, bound in (("lbx", self._model.lower), ("ubx", self._model.upper)):
                if self._bounded:
                    away = (bound - x)[self._bounded] / item.scale[self._bounded]
                    self._solver.set(k, field, np.clip(away, -FAR, FAR))
            self._solver.set(k, "x", np.zeros(self._model.n_x))
            if k < N:
                self._solver.set(k, "u", np.zeros(self._model.n_w))

    def solve(self) -> Counted | None:
        """Make the iteration."""
        self._status = self._solver.solve()
        return Counted(float(self._solver.get_stats("time_tot")[0])) if self._call_only else None

    def outcome(self) -> RaceOutcome:
        """Read the steps."""
        steps = [self._solver.get(0, "x")]
        for k in range(self._N):
            steps += [self._solver.get(k, "u"), self._solver.get(k + 1, "x")]
        trajectory = trajectory_of(np.concatenate(steps), self._window)
        return RaceOutcome(self._status == 0, trajectory.states[-1], trajectory)


@lru_cache(maxsize=2)
def _solver(model: StateSpaceModel, horizon: int, settings: AcadosSettings) -> Any:
    """Generate and compile a solver; two contenders in turn may share it."""
    library = acados_library()
    with tempfile.TemporaryDirectory() as folder, in_silence(), quietly_building(library):
        problem = acados_problem(library, model, horizon, settings, Path(folder))
        json = str(Path(folder) / "problem.json")
        return library.interface.AcadosOcpSolver(problem, json_file=json, verbose=False)


def acados_problem(
    library: AcadosLibrary,
    model: StateSpaceModel,
    horizon: int,
    settings: AcadosSettings,
    folder: Path,
) -> Any:
    """Return the ``AcadosOcp`` of windows of N intervals; generated code goes into the folder."""
    template = library.interface
    ocp = template.AcadosOcp()
    ocp.acados_include_path = str(library.installed / "include")
    ocp.acados_lib_path = str(library.installed / "lib")
    ocp.code_export_directory = str(folder / "code")
    ocp.dims.N = horizon
    # Of each solver its own: two libraries of one name would be one.
    ocp.model.name = f"window_{next(_NUMBER)}"
    _write_stages(ocp, model, settings)
    bounded = bounded_states(model)
    if bounded:
        limits = ocp.constraints
        for stage in ("_0", "", "_e"):
            setattr(limits, f"idxbx{stage}", np.array(bounded))
            setattr(limits, f"lbx{stage}", np.full(len(bounded), -1.0))
            setattr(limits, f"ubx{stage}", np.full(len(bounded), 1.0))
    options = ocp.solver_options
    options.tf = float(horizon)  # a weight of one for every stage
    options.integrator_type = "DISCRETE"
    options.nlp_solver_type = "SQP_RTI"
    options.hessian_approx = "GAUSS_NEWTON"
    options.qp_solver = "PARTIAL_CONDENSING_HPIPM"
    options.qp_solver_cond_N = max(horizon // settings.block, 1)
    options.hpipm_mode = settings.hpipm_mode
    options.qp_solver_warm_start = settings.warm_start
    options.levenberg_marquardt = settings.levenberg
    options.qp_solver_ric_alg = settings.riccati
    options.qp_solver_cond_ric_alg = settings.riccati
    options.ext_fun_compile_flags = FLAGS
    return ocp


def _write_stages(ocp: Any, model: StateSpaceModel, settings: AcadosSettings) -> None:
    """Write down dynamics and costs of a stage."""
    n_x, n_w = model.n_x, model.n_w
    d, omega = ca.SX.sym("d", n_x), ca.SX.sym("omega", n_w)
    (x, y, present, scale), r, H = linear_residual(model)
    w, dt, x_next = ca.SX.sym("w", n_w), ca.SX.sym("dt"), ca.SX.sym("x_next", n_x)
    x_prior, L_inverse = ca.SX.sym("x_prior", n_x), ca.SX.sym("L_inverse", n_x, n_x)
    minus_F, minus_G, b = linear_gap(model)(x, w, dt, x_next, scale)
    r_prior, W = linear_prior(model)(x, scale, x_prior, L_inverse)
    ocp.model.x, ocp.model.u = d, omega
    ocp.model.p = ca.veccat(x, y, present, scale, w, dt, x_next, x_prior, L_inverse)
    ocp.parameter_values = np.ones(ocp.model.p.numel())
    ocp.model.disc_dyn_expr = b - minus_F @ d - minus_G @ omega
    seen, noise = (r, H, d), (w, ca.SX.eye(n_w), omega)
    residuals = {"_0": ((r_prior, W, d), seen, noise), "": (seen, noise), "_e": (seen,)}
    for stage, parts in residuals.items():
        residual = ca.vertcat(*(offset + J @ step for offset, J, step in parts))
        setattr(ocp.cost, f"cost_type{stage}", settings.cost)
        if settings.cost == "NONLINEAR_LS":
            setattr(ocp.model, f"cost_y_expr{stage}", residual)
            setattr(ocp.cost, f"W{stage}", np.eye(residual.numel()))
            setattr(ocp.cost, f"yref{stage}", np.zeros(residual.numel()))
        else:
            variables = ca.vertcat(omega, d) if stage != "_e" else d
            J = ca.jacobian(residual, variables)
            setattr(ocp.model, f"cost_expr_ext_cost{stage}", ca.sumsqr(residual) / 2)
            setattr(ocp.model, f"cost_expr_ext_cost_custom_hess{stage}", J.T @ J)


def acados_parameters(window: SpeedWindow) -> list[Array]:
    """Return the parameters of every stage, linearised at the warm start."""
    model, N = window.model, len(window.dt)
    states, noises = window.guess.states, window.guess.noises
    prior = np.concatenate([window.prior.mean, window.prior_factor_inverse.ravel(order="F")])
    stages = []
    for k in range(N + 1):
        stage = (states[k], window.y[k], window.present[k], window.scale)
        onward = (
            (noises[k], window.dt[k : k + 1], states[k + 1])
            if k < N
            else (np.zeros(model.n_w), np.ones(1), states[k])
        )
        used = prior if k == 0 else np.zeros_like(prior)
        stages.append(np.concatenate([*stage, *onward, used]).astype(float))
    return stages
