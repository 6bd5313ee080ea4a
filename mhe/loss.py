"""Huber's loss, for readings with outliers and for process noise that is mostly still.

Of a whitened length a = √s, with s the squared residual of a sensor (all its rows
together) or of one noise, and a threshold k:

    ρ(s) = s / 2             where a ≤ k
           k a - k² / 2      beyond

Least squares with the weight ω = min(1, k / a) has the same slope as ρ and lies above it,
so solving it over and over with the last solution's weights (reweighting) descends on ρ.
On a noise it is the sum of norms of Ohlsson et al.: one large jump costs less than many
small ones.

References
----------
Huber (1964), Robust estimation of a location parameter, Ann. Math. Statist. 35(1).
Ohlsson, Gustafsson, Ljung, Boyd (2012), Smoothed state estimates under abrupt changes
using sum-of-norms regularization, Automatica 48(4).
"""

from __future__ import annotations

import casadi as ca

LEAST_SQUARES = 1e150
"""A threshold that nothing reaches, finite so that no branch is NaN."""


def huber(squared: ca.SX, threshold: ca.SX) -> ca.SX:
    """Return ρ(s)."""
    beyond = threshold * ca.sqrt(squared) - threshold**2 / 2
    return ca.if_else(squared <= threshold**2, squared / 2, beyond)


def huber_weight(squared: ca.SX, threshold: ca.SX) -> ca.SX:
    """Return ω, 1 at s = 0."""
    return ca.if_else(squared <= threshold**2, 1, threshold / ca.sqrt(squared))
