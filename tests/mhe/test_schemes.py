"""What the two real-time estimators share is one loop; what differs is data."""

from __future__ import annotations

import numpy as np
import pytest

from mhe.config import MheConfig, MheRtiConfig, RealTimeConfig
from mhe.realtime import Mhe, MheRti
from mhe.scheme import Scheme
from tests.engines import steps
from tests.mhe import pendulum

pytestmark = pytest.mark.usefixtures("interpreted")
SCHEMES: list[tuple[RealTimeConfig, Scheme]] = [
    (MheRtiConfig(), Scheme(converges=False, reuse_threshold=None)),
    (MheRtiConfig(reuse_threshold=0.3), Scheme(converges=False, reuse_threshold=0.3)),
    (
        MheConfig(tolerance=1e-3, max_iterations=4),
        Scheme(converges=True, tolerance=1e-3, max_iterations=4),
    ),
]


@pytest.mark.parametrize(("config", "scheme"), SCHEMES)
def test_a_config_says_how_passes_are_made(config: RealTimeConfig, scheme: Scheme) -> None:
    assert config.scheme == scheme


def test_neither_is_the_other() -> None:
    assert not issubclass(Mhe, MheRti)
    assert not issubclass(MheRti, Mhe)
    assert not hasattr(MheRti, "solve"), "one pass does not converge on a window"


def test_one_passes_once_and_the_other_until_it_is_there() -> None:
    model, measurements = pendulum.model(), pendulum.simulate(12, 1)
    once = steps(MheRti(model, MheRtiConfig(horizon=4)), measurements)
    there = steps(Mhe(model, MheConfig(horizon=4)), measurements)
    assert {estimate.iterations for estimate in once} == {1}
    assert max(estimate.iterations for estimate in there) > 2
    assert np.isfinite(there[-1].state.mean).all()
