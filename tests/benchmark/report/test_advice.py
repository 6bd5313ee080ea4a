"""Advice follows from the numbers, by rules: on made-up rows, the bad ones too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmark.report.advice import NO, OPEN, WITH, WITHOUT, YES, Advice, advice
from benchmark.report.belief import costs_of_belief
from benchmark.report.choice import is_far_beyond
from benchmark.report.content import Answer
from benchmark.report.in_short import headlines, in_short
from benchmark.report.matrix import MATRIX, SHOWN, Cell, Matrix, matrices
from tests.benchmark.verdicts.results_table import seeds, table

CASE = MATRIX[0].case
Runs = Mapping[tuple[str, str], Sequence[float]]
"""(sensors, estimator) → RMSE of each seed, deg."""


def rows(runs: Runs, blind: Sequence[str] = (), **more: Any) -> pd.DataFrame:
    """Elevation of the answer's case; sensors in `blind` do not show it."""
    made = [
        row
        for (sensors, estimator), values in runs.items()
        for row in seeds(
            list(values),
            **{
                "case": CASE, "sensors": sensors, "estimator": estimator, "unit": "deg",
                "quantity": "elevation", "observable": sensors not in blind, **more,
            },
        )
    ]  # fmt: skip
    return table(*made)


def matrix(runs: Runs, blind: Sequence[str] = (), **more: Any) -> Matrix:
    (found,) = matrices(rows(runs, blind, **more))
    return found


def advised(runs: Runs, blind: Sequence[str] = (), **more: Any) -> Advice:
    return advice(matrix(runs, blind, **more))


def said(found: Advice, budget: str = WITHOUT) -> str:
    pick = found.of(budget)
    return pick.sentence if pick else ""


def everything(found: Advice) -> str:
    return " ".join((said(found, WITH), said(found, WITHOUT), found.more))


STEADY = [0.20, 0.21, 0.22, 0.23]
LOST = [0.05, 0.06, 0.05, 50.6]
"""A small median and one seed that is lost."""


@pytest.mark.parametrize("claimed", [0.05, 20.0, float("nan")])
def test_an_estimator_with_a_lost_seed_is_never_named(claimed: float) -> None:
    """Whatever it claims: ``take gyro with ekf … worst seed 50.6 with ekf, 0.28 with mhe-rti``."""
    runs = {("gyro", "ekf"): LOST, ("gyro", "mhe-rti"): STEADY}
    found = advised(runs, claimed=claimed)
    assert said(found).startswith("Take gyro with mhe-rti (0.215 deg): the worst seed of ekf is")
    assert "50.6 deg" in said(found)
    assert said(found).endswith("far beyond 0.230 with mhe-rti.")
    assert "with ekf" not in everything(found)
    assert [(pick.budget, pick.pays, pick.cheaper) for pick in found.picks] == [(WITHOUT, YES, "")]


def test_nor_is_an_mhe_with_a_lost_seed() -> None:
    found = advised({("gyro", "ekf"): STEADY, ("gyro", "mhe-rti"): LOST})
    assert said(found).startswith("Take gyro with ekf (0.215 deg): the worst seed of mhe-rti is")
    assert "with mhe-rti" not in everything(found)


def test_a_lost_seed_makes_no_sensors_the_best() -> None:
    runs = {
        ("gyro", "ekf"): LOST,
        ("gyro", "mhe-rti"): [2.0, 2.0, 2.0, 2.1],
        ("camera", "ekf"): [1.0, 1.0, 1.1, 1.1],
        ("camera", "mhe-rti"): [1.0, 1.0, 1.1, 1.1],
    }
    found = advised(runs)
    assert said(found, WITH).startswith("Take camera with ekf")
    assert said(found, WITHOUT).startswith("Take gyro with mhe-rti (2.00 deg, 1.90 times the best)")
    assert found.more.startswith("Next: gyro, 2.00 deg with mhe-rti")


def test_of_two_mhes_the_one_that_is_lost_is_not_named() -> None:
    runs = {
        ("gyro", "ekf"): [1.0, 1.1, 1.2, 1.3],
        ("gyro", "mhe-rti"): LOST,
        ("gyro", "mhe"): STEADY,
    }
    found = advised(runs)
    assert said(found).startswith("Take gyro with mhe (0.215 deg)")
    assert "with mhe-rti" not in everything(found)


def test_seeds_without_a_figure_are_lost_seeds() -> None:
    """A run that broke off, or ended in the mirror."""
    of = rows({("gyro", "ekf"): STEADY, ("gyro", "mhe-rti"): [0.1] * 4})
    of.loc[(of["estimator"] == "mhe-rti") & (of["seed"] == 3), ["status", "rmse"]] = (
        "mirror",
        np.nan,
    )
    (found,) = matrices(of)
    assert said(advice(found)) == (
        "Take gyro with ekf (0.215 deg): mhe-rti has no figure for 1 of 4 seeds."
    )


def cell(high: float, by_claim: float = float("nan"), seeds: int = 4) -> Cell:
    return Cell(SHOWN, high / 2, high / 4, high, high, by_claim, seeds, 4)


@pytest.mark.parametrize(
    ("mine", "other", "beyond"),
    [
        (cell(50.6, 40.0), cell(0.28), True),
        (cell(50.6, 0.5), cell(0.28), True),  # it knows, but it is 180 times the other's
        (cell(2.1, 3.1), cell(1.0), True),
        (cell(2.1, 2.9), cell(1.0), False),  # as uncertain as it says
        (cell(2.1), cell(1.0), True),  # claims nothing
        (cell(1.9, 30.0), cell(1.0), False),
        (cell(1.0, 9.0), cell(1.0, 9.0), False),
        (cell(1.0, 1.0, seeds=3), cell(50.0, 1.0), True),
        (cell(1.0, 1.0, seeds=3), cell(1.0, 1.0, seeds=3), False),
        (cell(np.inf), cell(1.0), True),
        (cell(np.inf), cell(np.inf), False),
    ],
)
def test_what_is_far_beyond(mine: Cell, other: Cell, beyond: bool) -> None:
    assert is_far_beyond(mine, other) is beyond


def test_a_cell_has_the_claim_of_its_worst_seed() -> None:
    of = rows({("gyro", "ekf"): [1.0, 6.0, 2.0]})
    of["claimed"] = [1.0, 1.5, 4.0]
    (found,) = matrices(of)
    assert found.cell("gyro", "ekf").claimed == 1.5
    assert found.cell("gyro", "ekf").worst_by_claim == 4.0


ALONE = {
    ("accel", "ekf"): [5.0] * 3,
    ("gyro", "ekf"): [6.0] * 3,
    ("accel+gyro", "ekf"): [0.9, 1.0, 1.1],
    ("accel+gyro+contact", "ekf"): [0.8, 0.9, 1.0],
    ("camera", "ekf"): [0.3] * 3,
    ("accel+gyro+camera", "ekf"): [0.1] * 3,
}


def test_the_cheapest_without_a_camera_and_what_is_not_observable() -> None:
    found = advised(ALONE, blind=("accel", "gyro"))
    assert said(found, WITH).startswith("Take accel+gyro+camera with ekf (0.100 deg)")
    assert said(found, WITHOUT) == (
        "Take accel+gyro+contact with ekf (0.900 deg, 9.00 times the best); whether an MHE pays "
        "is open, because no run has both EKF and MHE. "
        "Cheapest that shows it: accel+gyro with ekf (1.00 deg, 10.0 times the best)."
    )
    assert [pick.pays for pick in found.picks] == [OPEN, OPEN]
    assert "Accelerometer alone and gyroscope alone: not observable." in found.more


def test_one_that_is_not_observable() -> None:
    found = advised(ALONE, blind=("gyro",))
    assert found.more.endswith("Gyroscope alone: not observable.")
    assert said(found).startswith("Take accel+gyro+contact with ekf (0.900 deg")
    assert "Cheapest that shows it: accel with ekf (5.00 deg" in said(found)


def test_the_best_without_a_camera_has_no_needless_sensor() -> None:
    runs = {**ALONE, ("accel+gyro+contact", "ekf"): [0.88, 0.98, 1.08]}
    found = advised(runs, blind=("accel", "gyro"))
    assert said(found).startswith("Take accel+gyro with ekf (1.00 deg, 10.0 times the best)")
    assert "heapest" not in said(found)


def test_nothing_without_a_camera_is_said_to_be_so() -> None:
    inertial = tuple(sensors for sensors, _ in ALONE if "camera" not in sensors)
    blind = advised(ALONE, blind=inertial)
    assert said(blind) == "Not observable."
    with_camera = {key: value for key, value in ALONE.items() if "camera" in key[0]}
    assert advised(with_camera).of(WITHOUT) is None


def test_an_infinite_figure_is_not_called_not_observable() -> None:
    found = advised({**ALONE, ("gyro", "ekf"): [np.inf] * 3}, blind=("accel",))
    assert "gyro" not in found.more.partition("Next")[2].partition("(")[2]
    assert found.more.endswith("Accelerometer alone: not observable.")


def test_nothing_to_advise() -> None:
    found = advised({("gyro", "ekf"): [1.0]}, blind=("gyro",))
    assert everything(found).strip() == "Nothing in this run gives it: there is nothing to advise."
    assert headlines([Answer(matrix({("gyro", "ekf"): [1.0]}, blind=("gyro",)), found)]) == []


def test_the_answer_in_short() -> None:
    """A sentence per budget, how often optimising pays, and a row per quantity and budget."""
    better = {
        ("gyro", "ekf"): [2.0, 2.1, 2.2, 2.3],
        ("gyro", "mhe"): [1.0, 1.05, 1.1, 1.15],
        ("camera", "ekf"): [0.5, 0.6, 0.7, 0.8],
        ("camera", "mhe"): [0.501, 0.6, 0.7, 0.8],
    }
    of = rows(better)
    tip = of.assign(quantity="tip", unit="mm", observable=of["sensors"] != "gyro")
    answers = [Answer(found, advice(found)) for found in matrices(pd.concat([of, tip]))]
    assert headlines(answers) == [
        "With a camera: take camera with ekf for elevation and tip.",
        "Without a camera: take gyro with mhe for elevation; tip cannot be observed.",
        "Optimising pays in 1 of these 3 choices: for elevation without a camera.",
    ]
    found = in_short(answers)
    assert [row[:5] for row in found] == [
        ("elevation", WITH, "camera", "ekf", "0.650 deg"),
        ("elevation", WITHOUT, "gyro", "mhe", "1.08 deg, 1.65 times the best"),
        ("tip", WITH, "camera", "ekf", "0.650 mm"),
        ("tip", WITHOUT, "not observable", "–", "–"),
    ]
    pays = [row[5].partition(":")[0] for row in found]
    assert pays == [NO, YES, NO, "–"]
    assert all(answer.advice.of(WITH).sentence.startswith("Take camera") for answer in answers)  # type: ignore[union-attr]


def test_where_optimising_pays_nowhere_it_is_said_so() -> None:
    of_each = {"ekf": [1.0, 1.1, 1.2], "mhe": [1.0, 1.1, 1.201]}
    same = {(s, e): of_each[e] for s in ("gyro", "camera") for e in of_each}
    found = matrix(same)
    said_last = headlines([Answer(found, advice(found))])[-1]
    assert said_last == (
        "Optimising pays in none of these 2 choices: "
        "nothing shows the EKF worse there, and it is cheaper."
    )


@pytest.mark.parametrize("estimators", [{"ekf": [1.0], "mhe": [1.1]}, {"ekf": [1.0, 1.1, 1.2]}])
def test_where_nothing_tells_whether_it_pays_that_is_said(
    estimators: dict[str, list[float]],
) -> None:
    """Not that it pays nowhere: one seed has no interval, and one estimator no other."""
    found = matrix({("gyro", name): errors for name, errors in estimators.items()})
    assert headlines([Answer(found, advice(found))])[-1] == (
        "Whether optimising pays is open: "
        "this run has too few seeds, or estimators of one kind only."
    )


def test_what_believing_in_no_spin_costs() -> None:
    free = rows({("accel+gyro", "ekf"): [1.0] * 3, ("gyro", "ekf"): [9.0] * 3}, blind=("gyro",))
    believed = rows(
        {
            ("accel+gyro", "ekf"): [25.0] * 3,
            ("accel+gyro", "mhe"): [20.0] * 3,
            ("gyro", "ekf"): [23.0] * 3,
            ("camera", "ekf"): [0.5] * 3,
        },
        blind=("gyro",),
        claimed=0.05,
    ).assign(case="spin ignored")
    assert costs_of_belief(pd.concat([free, believed])) == [
        "gyro: elevation 23.0 deg off, claiming 0.0500 (with ekf); "
        "of the free pen: not observable.",
        "accel+gyro: elevation 20.0 deg off, claiming 0.0500 (with mhe); "
        "the free pen 1.00 deg (with ekf, 20.0 times less).",
        "camera: elevation 0.500 deg off, claiming 0.0500 (with ekf); the free pen did not run.",
    ]
    assert costs_of_belief(free) == []
