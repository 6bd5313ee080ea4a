"""Values made without their constructors have all that these give them."""

from __future__ import annotations

import dataclasses

import numpy as np

from estimation.estimate import Estimate
from estimation.frozen import changed
from estimation.result import ResultReader
from models.gaussian import GaussianState
from models.pen import pen_model


def test_what_a_reader_makes_has_every_field() -> None:
    reader = ResultReader(pen_model("reference", ["accel"]))
    estimate = reader.estimate(np.ones(reader.layout.size))
    assert list(vars(estimate)) == [field.name for field in dataclasses.fields(Estimate)]
    assert repr(estimate) == repr(dataclasses.replace(estimate))


def test_a_changed_value_is_a_replaced_one() -> None:
    before = GaussianState(np.zeros(2), np.eye(2))
    after = changed(before, mean=np.ones(2))
    assert repr(after) == repr(dataclasses.replace(before, mean=np.ones(2)))
    assert not before.mean.any()
    assert after.covariance is before.covariance
