"""Sigma-lognormal handwriting: overlapping strokes of lognormal speed.

With s = t - t₀ > 0 and z = (ln s - μ) / σ a stroke of length D has the speed
D Λ(t), and its direction turns with its progress F(t) = ∫ Λ dt:

    Λ = exp(-z²/2) / (σ √(2π) s),      F = Φ(z) = ½ [1 + erf(z / √2)]
    φ = θ_s + (θ_e - θ_s) F,           v = D Λ (cos φ, sin φ)

Since dF = Λ dt, the path is an arc of a circle and has a closed form, here
written so that the straight stroke θ_e → θ_s loses no digits, as do the
derivatives of v:

    p = D F sinc(½ Δθ F) (cos, sin)(θ_s + ½ Δθ F),       sinc(a) = sin(a) / a
    a = D Λ' (cos φ, sin φ) + D Λ² Δθ (-sin φ, cos φ),   Λ' = -Λ (1 + z/σ) / s

The pen adds up its strokes. Lift and turns of the pen's angles follow F too.

References
----------
Plamondon (1995), A kinematic theory of rapid human movements, part I,
Biological Cybernetics 72, 295-307.
O'Reilly, Plamondon (2009), Development of a Sigma-Lognormal representation for
on-line signatures, Pattern Recognition 42(12), 3324-3337.
The third dimension and the angles are this project's addition.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PositiveFloat
from scipy.special import ndtr

from models.arrays import Array
from models.config import UnitConfig
from models.sensor_kinds.mounted import NonNegative, Vector3


class LognormalStroke(UnitConfig):
    """One stroke.

    Parameters
    ----------
    t0_s : time of its command; it moves noticeably some time after it
    D_m : its length along the path; a stroke of length 0 may still lift and turn
    mu : its median comes exp(μ) seconds after t0; larger is slower
    sigma : its spread in log time; larger is a longer, more skewed speed profile
    start_rad, end_rad : direction of motion on the desk at its begin and end
    lift_m : change of the tip's height
    turn_rad : changes of azimuth, elevation and spin
    """

    t0_s: float
    D_m: NonNegative
    mu: float
    sigma: PositiveFloat
    start_rad: float
    end_rad: float
    lift_m: float = 0.0
    turn_rad: Vector3 = (0.0, 0.0, 0.0)


class SigmaLognormal(UnitConfig):
    """Strokes that add up, from a first pose.

    Parameters
    ----------
    description : what it draws
    tip_m : the tip before the first stroke
    angles_rad : azimuth, elevation and spin before the first stroke
    strokes : in any order; they may overlap in time
    """

    kind: Literal["sigma_lognormal"] = "sigma_lognormal"
    description: str
    tip_m: Vector3 = (0.0, 0.0, 0.0)
    angles_rad: Vector3
    strokes: Annotated[tuple[LognormalStroke, ...], Field(min_length=1)]


def sigma_lognormal(config: SigmaLognormal, time_s: Array) -> tuple[Array, Array, Array]:
    """Return q, q̇, q̈, each (n, 6), of the sum of all strokes.

    Parameters
    ----------
    time_s : (n,) sampling instants, s
    """
    first = np.array([*config.tip_m, *config.angles_rad])
    q = np.tile(first, (len(time_s), 1))
    q_dot, q_ddot = np.zeros_like(q), np.zeros_like(q)
    for stroke in config.strokes:
        F, speed, slope = _lognormal(time_s - stroke.t0_s, stroke.mu, stroke.sigma)
        D, bend = stroke.D_m, stroke.end_rad - stroke.start_rad
        chord = bend * F / 2
        phi = stroke.start_rad + bend * F
        along, across = _direction(phi), _direction(phi + np.pi / 2)
        # numpy's sinc(u) is sin(π u) / (π u).
        reach = D * F * np.sinc(chord / np.pi)
        q[:, :2] += reach[:, None] * _direction(stroke.start_rad + chord)
        q_dot[:, :2] += (D * speed)[:, None] * along
        q_ddot[:, :2] += (D * slope)[:, None] * along + (D * speed**2 * bend)[:, None] * across
        change = np.array([stroke.lift_m, *stroke.turn_rad])
        q[:, 2:] += np.outer(F, change)
        q_dot[:, 2:] += np.outer(speed, change)
        q_ddot[:, 2:] += np.outer(slope, change)
    return q, q_dot, q_ddot


def _lognormal(s: Array, mu: float, sigma: float) -> tuple[Array, Array, Array]:
    """Return F, Λ, Λ', each (n,), of a time s after t₀; all zero up to there."""
    begun = s > 0
    s = np.where(begun, s, 1.0)
    z = (np.log(s) - mu) / sigma
    speed = np.exp(-(z**2) / 2) / (sigma * np.sqrt(2 * np.pi) * s)
    slope = -speed * (1 + z / sigma) / s
    return np.where(begun, ndtr(z), 0.0), np.where(begun, speed, 0.0), np.where(begun, slope, 0.0)


def _direction(angle: Array) -> Array:
    """Return the (n, 2) unit vectors of angles (n,)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
