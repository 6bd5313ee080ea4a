"""The models of the contract, and which of them the quick tests export."""

from __future__ import annotations

from typing import Any

import pytest

from benchmark.configurations import contract_models

MODELS = contract_models()
QUICK_PENS = ("pen6 accel+gyro+camera", "pen5 accel+gyro+contact", "pen6 two accelerometers")
"""The pens that quick tests export; all of them stand in the slow ones."""


def of_a_kind() -> list[Any]:
    """Return the names of all models; most pens are slow."""
    return [
        pytest.param(name, marks=pytest.mark.slow if is_slow else ())
        for name in MODELS
        for is_slow in [name.startswith("pen") and name not in QUICK_PENS]
    ]
