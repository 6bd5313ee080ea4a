"""Carriers that turn, and what an accelerometer on them reads."""

from __future__ import annotations

import math

import numpy as np

from models.arrays import Array

FORMS = ("smooth", "tangents")
SIGNS = ("turned", "previous")


def about_x(theta: Array) -> Array:
    """What a resting accelerometer reads of a carrier turned about x, (n, 3)."""
    return np.column_stack([np.zeros_like(theta), np.sin(theta), np.cos(theta)])


def about_y(phi: Array) -> Array:
    return np.column_stack([np.sin(phi), np.zeros_like(phi), np.cos(phi)])


def only_first(acceleration: Array) -> Array:
    """Leave the rest to the gyroscope: without an acceleration what it says is kept."""
    return np.vstack([acceleration[:1], np.zeros_like(acceleration[1:])])


def noisy_turn(seed: int, n: int = 400) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    time_s = np.cumsum(rng.uniform(0.005, 0.015, n))
    theta = 2 * math.pi * (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    acceleration = 9.81 * about_x(theta) + rng.normal(0, 0.3, (n, 3))
    rates = np.column_stack([np.gradient(theta, time_s), np.zeros(n)]) + rng.normal(0, 0.1, (n, 2))
    return time_s, acceleration, rates
