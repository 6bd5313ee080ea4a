"""The command that answers a question about a pen: observe."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from typer.testing import CliRunner

from commands.cli import app
from pen_mhe.sensor_verdict import MOTIONS

pytestmark = pytest.mark.usefixtures("interpreted")


def call(*arguments: str) -> Any:
    return CliRunner().invoke(app, arguments)


def rows(output: str) -> dict[str, list[str]]:
    """First cell of every row of a Markdown table → the other cells."""
    lines = [line for line in output.splitlines() if line.startswith("| ")]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {first: others for first, *others in cells}


@cache
def observed(*options: str) -> str:
    result = call("observe", "--duration", "0.5", *options)
    assert result.exit_code == 0, result.stderr
    return str(result.stdout)


def check_sentence(result: Any, sentence: str) -> None:
    assert result.exit_code == 2
    assert result.stdout == ""
    message = result.stderr.strip()
    assert message.startswith("pen-mhe: ")
    assert "\n" not in message
    assert sentence in message


def test_observe_says_that_inertial_sensors_do_not_see_azimuth() -> None:
    printed = observed("--sensors", "accel,gyro")
    title = printed.splitlines()[0]
    assert title == "reference pen, 6 degrees of freedom: accel, gyro, area, rest; 0.5 s"
    table = rows(printed)
    assert len(table) == 2 + 24  # three angles in place of the attitude's three numbers
    assert table["state"] == ["known before (std)", *MOTIONS]
    _, *azimuth = table["azimuth_rad"]
    assert len(azimuth) == len(MOTIONS)
    assert all(cell.startswith("not observable (") for cell in azimuth)
    before, *rates = table["body_rate_z_rad_s"]
    assert before == "1 rad/s"
    assert not any("not observable" in cell for cell in rates)
    assert "no reading shows turning about the vertical alone" in printed
    for motion in MOTIONS:
        assert f"{motion}: " in printed
    assert "23 of 24 directions are observable" in printed


def test_without_the_area_observe_says_that_nothing_holds_the_tip() -> None:
    with_area = observed("--sensors", "accel,gyro")
    without = observed("--sensors", "accel,gyro", "--no-writing-area")
    assert without.splitlines()[0].endswith("accel, gyro, rest; 0.5 s")
    assert "no reading shows tip_x_m alone" in without
    assert "no reading shows tip_x_m alone" not in with_area
    for state in ("tip_x_m", "tip_x_velocity_m_s"):
        assert "not observable" in rows(without)[state][1]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            ("observe", "--sensors", "accel,radar"),
            "sensor radar is not in the pen reference pen; expected one of accel, gyro",
        ),
        (("observe", "--duration", "0"), "duration is 0.0 s, expected a positive time"),
        (("observe", "--pen", "nowhere.toml"), "pen file nowhere.toml does not exist"),
    ],
)
def test_a_bad_call_gets_one_sentence(arguments: tuple[str, ...], sentence: str) -> None:
    check_sentence(call(*arguments), sentence)
