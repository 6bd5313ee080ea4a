"""The models of the contract, and which of them the quick tests export."""

from __future__ import annotations

from typing import Any

import pytest

from benchmark.configurations import contract_models

MODELS = contract_models()
ALIKE = {"accel", "gyro", "camera", "two accelerometers+camera"}
"""Choices of a pen's sensors that are parts of others in the list, or made of them."""


def of_a_kind() -> list[Any]:
    """Return the names of all models; pens with a choice that is alike are slow."""
    return [
        pytest.param(name, marks=pytest.mark.slow if is_alike else ())
        for name in MODELS
        for is_alike in [name.startswith("pen") and name.split(maxsplit=1)[1] in ALIKE]
    ]
