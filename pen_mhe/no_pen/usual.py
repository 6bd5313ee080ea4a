"""The estimator that is taken where nobody names one, with a pen file and without."""

from __future__ import annotations

from models.pen_file import AnyPen
from pen_mhe.estimators import DEFAULT_ESTIMATOR

WITHOUT_PEN = "mhe-rti"
"""Of a recording without a pen file: one pass a sample."""


def usual_estimator(pen: AnyPen | None) -> str:
    """Return the estimator that is taken where nobody names one."""
    return DEFAULT_ESTIMATOR if pen is not None else WITHOUT_PEN
