"""A problem of ``classics.toml``: what the file says in words, as functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from models.arrays import Array
from models.differential import ode
from models.own_bounds import Bound
from suites.classics.rates import Figures, Rate


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what moves a problem beside its rate; 0 where nothing does.

    Parameters
    ----------
    behind : (n_x,) added behind a step, per √s
    on_rates : (n_x,) of a rate, held over a step
    on_inputs : (n_u,) of a known input, held over a step
    """

    behind: Array
    on_rates: Array
    on_inputs: Array

    @classmethod
    def of(
        cls,
        n_x: int,
        n_u: int,
        behind: object = 0.0,
        on_rates: object = 0.0,
        on_inputs: object = 0.0,
    ) -> Noise:
        """Return the noise of n_x states and n_u inputs; one number is for all of them."""
        sizes = (n_x, n_x, n_u)
        given = zip((behind, on_rates, on_inputs), sizes, strict=True)
        return cls(*(np.broadcast_to(np.asarray(std, float), (n,)) for std, n in given))

    def factors(self) -> tuple[Array, Array, Array]:
        """Return a matrix (n, k) for each that takes k unit noises, one for each that is not 0."""
        stds = (self.behind, self.on_rates, self.on_inputs)
        behind, rates, inputs = (np.diag(std)[:, std > 0] for std in stds)
        return behind, rates, inputs

    @property
    def n_w(self) -> int:
        """Number of independent unit noises."""
        return sum(factor.shape[1] for factor in self.factors())


def start_of_file(given: Figures, rng: np.random.Generator) -> Array:
    """Return the truth's first state as the file has it."""
    return np.atleast_1d(np.asarray(given["truth"], dtype=float))


def prior_of_file(given: Figures) -> tuple[Array, Array]:
    """Return mean and standard deviations (n_x,) as the file has them."""
    mean, std = (np.asarray(given["prior"][name], float) for name in ("mean", "std"))
    return np.atleast_1d(mean), np.atleast_1d(std)


def no_inputs(given: Figures, time_s: Array, rng: np.random.Generator) -> Array:
    """Return known inputs (n, 0)."""
    return np.zeros((len(time_s), 0))


@dataclass(frozen=True, kw_only=True)
class ClassicProblem:
    """What the file says in words, as functions of its figures.

    Parameters
    ----------
    title : for people
    states, axes, inputs : names of the states, of the readings and of known inputs → unit
    rate : ẋ
    reads : (x, figures) → the readings
    noise : figures → the noise
    judged : the state of which the suite speaks
    label : of its axis, with its unit
    from_s : from when on it is judged
    prior : figures → mean and standard deviations (n_x,)
    bounds : figures → state → (lower, upper), obeyed by the moving-horizon estimators
    substeps : of the integration within a sample
    truth : the truth's first state
    signals : (figures, time (n,), random numbers) → the inputs (n, n_u) that act
    kept : states whose noise the estimators reckon with, and the truth has not
    is_prior_drawn : whether the prior's mean is drawn about the truth's start, run by run
    is_within_bounds : whether a truth that leaves the bounds is drawn anew
    is_reflected : whether the truth turns back at the bound, beyond which there is no reading
    succeeds_below : figures → RMS error of the judged state up to which a run succeeds
    is_linear : whether every estimator must be the Kalman filter
    """

    title: str
    states: Mapping[str, str]
    axes: Mapping[str, str]
    rate: Rate
    reads: Callable[[ca.SX, Figures], ca.SX]
    noise: Callable[[Figures], Noise]
    judged: str
    label: str
    from_s: float
    inputs: Mapping[str, str] = field(default_factory=dict)
    prior: Callable[[Figures], tuple[Array, Array]] = prior_of_file
    bounds: Callable[[Figures], Mapping[str, Bound]] = lambda given: {}
    substeps: int = 1
    truth: Callable[[Figures, np.random.Generator], Array] = start_of_file
    signals: Callable[[Figures, Array, np.random.Generator], Array] = no_inputs
    kept: tuple[str, ...] = ()
    is_prior_drawn: bool = False
    is_within_bounds: bool = False
    is_reflected: bool = False
    succeeds_below: Callable[[Figures], float] | None = None
    is_linear: bool = False

    def transition(self, given: Figures) -> Callable[..., ca.SX]:
        """Return (x, w, Δt, u) → the next x. Noise behind a step grows as √Δt between samples.

        What is held over a step of dt at s w is, to `ode`, of density s √dt.
        """
        behind, on_rates, on_inputs = self.noise(given).factors()
        n_behind, n_rates = behind.shape[1], on_rates.shape[1]
        root = float(np.sqrt(given["dt_s"]))

        def rate(x: ca.SX, w: ca.SX, *u: ca.SX) -> ca.SX:
            acting = ca.vertcat(*u) + root * _by(on_inputs, w[n_rates:])
            return self.rate(x, acting, given) + root * _by(on_rates, w[:n_rates])

        follow = ode(rate, substeps=self.substeps)

        def moved(x: ca.SX, w: ca.SX, dt: ca.SX, *u: ca.SX) -> ca.SX:
            after = follow(x, w[n_behind:], dt, *u)
            return after + ca.sqrt(dt) * _by(behind, w[:n_behind])

        return moved


def _by(factor: Array, w: ca.SX) -> ca.SX:
    """Return what unit noises (k,) do by their factor (n, k)."""
    return ca.DM(factor) @ ca.reshape(w, factor.shape[1], 1)
