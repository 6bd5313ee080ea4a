"""Counting false alarms: what is run, what is kept, what is printed."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from recordings.motion_list import DRAWN
from suites.faults import calibrate, clean, false_alarms
from suites.faults.clean import SPEEDS
from suites.faults.false_alarms import AlarmPart, table, wanted, watched_part
from suites.faults.kept_runs import kept
from suites.faults.protocol import MOTION

BOTH = "accel+gyro"


def test_a_quarter_of_the_hours_at_each_speed_on_seeds_of_its_own() -> None:
    found = list(wanted("a build", ["ekf"], [BOTH], 10.0))
    seconds = Counter[float]()
    for part in found:
        seconds[part.speed] += false_alarms.PART_S
    assert seconds == dict.fromkeys(SPEEDS, pytest.approx(10 * 3600 / 4))
    assert Counter(part.motion for part in found)[DRAWN] == len(found) / 2
    seeds = {part.seed for part in found}
    assert min(seeds) > max(calibrate.FIRST_SEED, clean.FIRST_SEED) + 1000
    assert {part.speed for part in found[: 2 * len(SPEEDS)]} == set(
        SPEEDS
    )  # ended early, all alike


def test_what_was_done_by_the_same_build_is_not_done_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    done = list[AlarmPart]()

    def fake(part: AlarmPart) -> AlarmPart:
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(part)
        return replace(part, lost_s=1.5, raised={"accel": 2, "accel:outlier": 2, "unexplained": 1})

    path = tmp_path / "alarms.jsonl"
    given = ["-", "--hours", "0.1", "--sensors", BOTH, "--output", str(path)]
    monkeypatch.setattr(sys, "argv", given)
    monkeypatch.setattr(false_alarms, "watched_part", fake)
    monkeypatch.setattr(false_alarms, "code_identity", lambda: "one")
    with pytest.raises(KeyboardInterrupt):
        false_alarms.main()
    assert len(kept(path, AlarmPart)) == 3
    first = [part.key for part in done]
    done.clear()
    monkeypatch.setattr(false_alarms, "watched_part", lambda part: done.append(part) or part)
    false_alarms.main()
    assert not set(first) & {part.key for part in done}
    assert len(kept(path, AlarmPart)) == len(first) + len(done) == 2 * len(SPEEDS)
    printed = capsys.readouterr().out
    assert f"ekf, {BOTH}" in printed
    assert "accel:outlier" in printed
    done.clear()
    monkeypatch.setattr(false_alarms, "code_identity", lambda: "another")
    false_alarms.main()
    assert len(done) == len(kept(path, AlarmPart)) == 2 * len(SPEEDS)


@pytest.mark.parametrize(
    ("hours", "output", "said"),
    [
        ("0", "new.jsonl", "--hours is 0.0"),
        ("1", "old.toml", "not of this command"),
        ("1", "nowhere/new.jsonl", "there is no folder"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    hours: str,
    output: str,
    said: str,
) -> None:
    (tmp_path / "old.toml").write_text("at_s = 3.0\n", "utf-8")
    given = ["-", "--hours", hours, "--output", str(tmp_path / output)]
    monkeypatch.setattr(sys, "argv", given)
    with pytest.raises(SystemExit):
        false_alarms.main()
    assert said in capsys.readouterr().err
    assert (tmp_path / "old.toml").read_text("utf-8") == "at_s = 3.0\n"


def test_flags_are_of_an_hour_and_a_sensor() -> None:
    part = AlarmPart("a build", "ekf", BOTH, MOTION, 1.0, 1, livelier_s=15.0)
    flagged = replace(part, raised={"accel": 2, "accel:stuck": 2, "gyro": 1}, lost_s=3.0)
    hours = 2 * false_alarms.PART_S / 3600
    line = next(line for line in table([part, flagged]).splitlines() if "speed 1," in line)
    assert f"{3 / hours / 2:.3g} flags an hour and sensor" in line
    assert "lost 1 %" in line
    assert "livelier 10 %" in line
    assert "speed 2: nothing yet" in table([part])


@pytest.mark.parametrize("motion", [MOTION, DRAWN])
def test_a_usual_motion_is_not_flagged(monkeypatch: pytest.MonkeyPatch, motion: str) -> None:
    monkeypatch.setattr(false_alarms, "PART_S", 4.0)
    found = watched_part(AlarmPart("a build", "ekf", BOTH, motion, 0.3, 20_000))
    assert (found.raised, found.lost_s, found.livelier_s) == ({}, 0.0, 0.0)
