"""Quantiles of the χ² distribution; `scipy.stats`, which has them too, takes a second to import."""

from __future__ import annotations

from typing import Any

from scipy.special import chdtri, gammaincinv


def quantile(probability: Any, freedom: Any) -> Any:
    """Return what a χ² variable is below with a probability, as ``scipy.stats.chi2.ppf``."""
    return 2 * gammaincinv(freedom / 2, probability)


def upper_quantile(probability: Any, freedom: Any) -> Any:
    """Return what a χ² variable is above with a probability, as ``scipy.stats.chi2.isf``."""
    return chdtri(freedom, probability)
