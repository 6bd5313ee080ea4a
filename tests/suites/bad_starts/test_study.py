"""The command bad-starts: tables, file and figure of the same runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt
from matplotlib.text import Text
from typer.testing import CliRunner

from commands.cli import app
from suites.bad_starts.cases import CASES, KNOWLEDGE
from suites.bad_starts.run import BadStartRun, run_bad_start, summary
from suites.bad_starts.study import FIGURE_CASES, QUANTITIES, TABLES, bad_starts_figure

CASE = "gesture-30"


def call(*arguments: str) -> Any:
    return CliRunner().invoke(app, ["bad-starts", *arguments])


def test_tables_and_file_show_the_same_runs(tmp_path: Path) -> None:
    output = tmp_path / "made"
    arguments = ("--cases", CASE, "--estimators", "ekf", "--runs", "3", "--jobs", "1")
    result = call(*arguments, "--output", str(output))
    assert result.exit_code == 0, result.stderr
    assert sorted(path.name for path in output.iterdir()) == [
        "bad_starts.csv",
        "bad_starts.png",
        "journal-bad-starts.jsonl",
        "journal-bad-starts.jsonl.lock",
    ]
    assert (output / "bad_starts.png").read_bytes().startswith(b"\x89PNG")
    expected = summary(CASES[CASE], "ekf", [run_bad_start(CASES[CASE], "ekf", k) for k in range(3)])
    (row,) = pd.read_csv(output / "bad_starts.csv").to_dict("records")
    assert row == pytest.approx(expected, nan_ok=True)
    first = f"| {CASES[CASE].label} | {KNOWLEDGE[CASES[CASE].knowledge].label} | 30 |"
    lines = [line for line in result.stdout.splitlines() if line.startswith(first)]
    assert lines == [f"{first} {cell(expected)} |" for cell in TABLES.values()]
    assert result.stdout.count("; 3 runs each") == len(TABLES)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--cases", "writing-20"), "case writing-20 is unknown, expected one of writing-0, "),
        (("--estimators", "eks"), "estimator eks is unknown, expected one of ekf, "),
        (("--cases", ","), "',' has no name in it"),
    ],
)
def test_a_bad_call_gets_one_sentence(arguments: tuple[str, ...], sentence: str) -> None:
    result = call(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert sentence in result.stderr
    assert "\n" not in result.stderr.strip()


def made_up_run(error: float) -> BadStartRun:
    time_s = np.arange(301) / 100
    ones = np.ones(301)
    return BadStartRun(0, 0.5, time_s, error * ones, 0.1 * ones, 3 * error * ones, 1.0)


def test_the_figure_draws_medians_of_absolute_errors() -> None:
    """Errors 1 … 5: median 3; 10 % and 90 % are 1.4 and 4.6; rates three times that."""
    runs = {
        (case, estimator): [made_up_run(k * scale) for k in range(1, 6)]
        for case in FIGURE_CASES
        for estimator, scale in (("ekf", 1.0), ("mhe", 0.1))
    }
    figure = bad_starts_figure(runs, FIGURE_CASES, ("ekf", "mhe"))
    assert len(figure.axes) == len(FIGURE_CASES) * len(QUANTITIES)
    for axes, label, factor in ((figure.axes[0], "up", 1), (figure.axes[1], "rate", 3)):
        assert label in axes.get_ylabel()
        assert " / rad" in axes.get_ylabel() or " / (rad/s)" in axes.get_ylabel()
        ekf, mhe = axes.get_lines()[0], axes.get_lines()[2]
        assert (ekf.get_label(), mhe.get_label()) == ("ekf", "mhe")
        np.testing.assert_allclose(np.asarray(ekf.get_ydata(), dtype=float), 3 * factor)
        np.testing.assert_allclose(np.asarray(mhe.get_ydata(), dtype=float), 0.3 * factor)
        band = axes.collections[0].get_paths()[0].vertices[:, 1]
        assert (band.min(), band.max()) == pytest.approx((1.4 * factor, 4.6 * factor))
    assert figure.axes[-1].get_xlabel() == "time / s"
    plt.close(figure)
    assert all(case in CASES for case in FIGURE_CASES)


@pytest.mark.parametrize("case", ["writing-30", "no-spin-30", "gesture-30"])
def test_titles_of_a_single_case_are_within_the_figure(case: str) -> None:
    runs = {(case, "ekf"): [made_up_run(1.0)] * 1000}
    figure = bad_starts_figure(runs, [case], ["ekf"])
    figure.draw_without_rendering()
    titles = [
        text
        for text in figure.findobj(Text)
        if "1000 runs" in text.get_text() or "told: " in text.get_text()
    ]
    assert len(titles) == 2
    for text in titles:
        extent = text.get_window_extent()
        assert extent.x0 >= 0, text
        assert extent.x1 <= figure.bbox.x1, text
    plt.close(figure)
