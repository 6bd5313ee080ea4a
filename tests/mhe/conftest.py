"""Fixtures of the moving-horizon estimators."""

from __future__ import annotations

import pytest


@pytest.fixture(params=["compiled", "interpreted"])
def engine(request: pytest.FixtureRequest) -> None:
    """One engine, then the other."""
    if request.param == "interpreted":
        request.getfixturevalue("interpreted")
