"""Tasks and quantities: what their figures mean."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmark.tasks.task import FAILED, Quantity, Task, failed


def test_errors_of_a_number() -> None:
    errors = [3.0, -4.0, 1.0]
    found = Quantity.of_errors("elevation", "deg", np.array(errors), observable=False)
    assert found.rmse == pytest.approx(math.sqrt((9 + 16 + 1) / 3))
    assert (found.bias, found.max_error) == (0.0, 4.0)
    assert (found.name, found.unit, found.observable) == ("elevation", "deg", False)
    assert found == Quantity.of_errors("elevation", "deg", np.array(errors)[:, None], False)


def test_errors_of_a_vector_are_lengths() -> None:
    errors = np.array([[3.0, 4.0], [3.0, -4.0], [0.0, 0.0], [6.0, 0.0]])
    found = Quantity.of_errors("tip", "mm", errors)
    assert found.rmse == pytest.approx(math.sqrt((25 + 25 + 0 + 36) / 4))
    assert found.bias == pytest.approx(3.0)  # of the mean error (3, 0)
    assert found.max_error == 6.0
    turned = errors @ np.array([[0.6, -0.8], [0.8, 0.6]])
    again = Quantity.of_errors("tip", "mm", turned)
    assert (again.rmse, again.bias, again.max_error) == pytest.approx(
        (found.rmse, found.bias, found.max_error)
    )


def test_what_was_claimed_of_a_vector_adds_up_as_variances() -> None:
    """So that it compares with the RMSE, whose errors are lengths."""
    std = np.array([[3.0, 4.0], [6.0, 8.0]])
    found = Quantity.of_errors("tip", "mm", std, claimed=std)
    assert found.claimed == pytest.approx(found.rmse)
    one = Quantity.of_errors("elevation", "deg", std[:, 0], claimed=std[:, 0])
    assert one.claimed == pytest.approx(math.sqrt((9 + 36) / 2))
    assert Quantity.of_errors("tip", "mm", std).claimed is None


@pytest.mark.parametrize("figure", [0.0, -2.5, 7.0, math.inf])
def test_a_single_figure(figure: float) -> None:
    found = Quantity.single("settling", "s", figure)
    assert (found.rmse, found.bias, found.max_error) == (abs(figure), figure, abs(figure))


def test_a_task_is_its_fields() -> None:
    task = Task("pen", "rest", "accel", "ekf", 3)
    assert task.key == "pen/rest/accel/ekf/3"
    assert task == Task("pen", "rest", "accel", "ekf", 3)
    assert sorted([Task("pen", "rest", "accel", "ekf", 10), task])[0] is task


def test_a_failed_task_has_its_reason_and_no_figures() -> None:
    found = failed("it broke")
    assert (found.status, found.reason, found.quantities) == (FAILED, "it broke", ())
    assert (found.samples, found.solved_fraction) == (0, 0.0)
    assert math.isnan(found.step_time_median_s)
    assert math.isnan(found.step_time_p99_s)
