"""Clock and frame of a copy of the truth are found, to the digits that the copy has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from pen_mhe.truth.align import Alignment, NotAligned, aligned
from pen_mhe.truth.words import alignment_sentence
from recordings.truths.read import read_truth
from recordings.truths.track import TruthTrack
from tests.pen_mhe.truth.truths import (
    LEVER_M,
    MOUNT,
    OFFSET_S,
    SHIFT_M,
    WORLD,
    angles,
    exact,
    marker,
    tablet,
    written,
)


def _found(track: TruthTrack, **said: object) -> Alignment:
    found = aligned(track, exact(), **said)  # type: ignore[arg-type]
    assert isinstance(found, Alignment), found
    return found


def test_a_marker_with_y_up_gives_its_clock_its_world_its_turn_and_its_place_on_the_pen(
    tmp_path: Path,
) -> None:
    found = _found(read_truth(written(marker(), tmp_path), "reference"))
    frame = found.fitted.frame
    assert abs(found.fitted.clocks.offset_s - OFFSET_S) < 1e-6
    np.testing.assert_allclose(frame.world, WORLD, atol=1e-6)
    np.testing.assert_allclose(frame.mount, MOUNT, atol=1e-6)
    np.testing.assert_allclose(frame.lever, LEVER_M, atol=1e-6)
    np.testing.assert_allclose(frame.shift, SHIFT_M, atol=1e-6)
    assert found.fitted.unknowns.count == 11
    assert "its y upward" in alignment_sentence(found)
    assert "11 numbers fitted" in alignment_sentence(found)


def test_a_tablet_in_mm_whose_y_points_down_is_turned_over(tmp_path: Path) -> None:
    found = _found(read_truth(written(tablet(), tmp_path), "reference"))
    assert abs(found.fitted.clocks.offset_s - (OFFSET_S - 200)) < 5e-4  # stamps of 1 ms
    truth = found.truth(exact(), exact().time_s)
    assert truth.names == ("tip_x_m", "tip_y_m")
    assert exact().position is not None
    away = truth.values - exact().position[:, :2]
    assert np.nanmax(np.abs(away)) < 2e-5
    assert 0.5 < np.isfinite(away[:, 0]).mean() < 0.75  # while the pen is down


def test_angles_in_degrees_turned_about_the_vertical(tmp_path: Path) -> None:
    found = _found(read_truth(written(angles(azimuth_rad=0.6), tmp_path), "reference"))
    assert abs(found.fitted.clocks.offset_s - OFFSET_S) < 1e-5
    assert abs(found.fitted.frame.heading_rad + 0.6) < 1e-6
    assert found.fitted.unknowns.count == 2


def test_elevation_alone_gives_a_clock_and_elevation_alone(tmp_path: Path) -> None:
    table = angles()[["time_s", "elevation_deg"]]
    found = _found(read_truth(written(table, tmp_path), "reference"))
    assert abs(found.fitted.clocks.offset_s - OFFSET_S) < 1e-5
    assert found.fitted.unknowns.count == 1
    assert found.truth(exact(), exact().time_s).names == ("elevation_rad",)


@pytest.mark.slow
def test_a_clock_that_drifts_is_followed_where_that_matters() -> None:
    track = exact()
    # Twice the recording, one after the other, so that it is long enough to tell.
    both = _twice(track)
    drifting = replace(both, time_s=both.time_s * (1 - 400e-6) - OFFSET_S)
    found = aligned(drifting, both)
    assert isinstance(found, Alignment)
    assert found.drift_matters
    assert abs(found.fitted.clocks.drift - 400e-6) < 5e-6
    away = found.fitted.clocks.of_truth(both.time_s) - drifting.time_s
    assert np.abs(away).max() < 1e-4
    back = found.fitted.clocks.of_estimate(found.fitted.clocks.of_truth(both.time_s))
    np.testing.assert_allclose(back, both.time_s, atol=1e-9)


def _twice(track: TruthTrack) -> TruthTrack:
    assert track.position is not None
    assert track.angles is not None
    assert track.attitude is not None
    end_s = track.time_s[-1] + 0.01
    later = {"time_s": np.append(track.time_s, track.time_s + end_s)}
    for name in ("position", "angles", "attitude"):
        part = getattr(track, name)
        later[name] = np.vstack([part, part[::-1]])
    return replace(track, **later)  # type: ignore[arg-type]


def test_what_is_said_of_clock_and_frame_is_taken_as_it_is() -> None:
    moved = replace(exact(), time_s=exact().time_s - 2.0)
    found = _found(moved, offset_s=2.0, frame="same")
    assert found.fitted.unknowns.count == 0
    assert "nothing is fitted" in alignment_sentence(found)
    assert exact().position is not None
    shown = found.truth(exact(), exact().time_s)
    np.testing.assert_allclose(shown.values[:, :3], exact().position, atol=1e-9)


def test_a_pen_at_rest_shows_no_clock() -> None:
    t = np.arange(0.0, 5.0, 0.01)
    still = TruthTrack("still", t, angles=np.tile([0.1, 0.9, 0.2], (len(t), 1)), is_level=True)
    found = aligned(still, exact())
    assert isinstance(found, NotAligned)
    assert "the truth does not change" in found.why
    assert "--truth-offset" in found.why


def test_another_motion_shows_no_clock() -> None:
    assert exact().angles is not None
    t, rng = exact().time_s, np.random.default_rng(4)
    smooth = np.apply_along_axis(
        lambda column: np.convolve(column, np.hanning(60), "same"),
        0, rng.normal(0, 0.05, (len(t), 3)),
    )  # fmt: skip
    found = aligned(TruthTrack("other", t, angles=smooth + 0.8, is_level=True), exact())
    assert isinstance(found, NotAligned)


def test_a_truth_of_another_day_does_not_overlap() -> None:
    found = aligned(exact(), exact(), offset_s=100.0)
    assert isinstance(found, NotAligned)
    assert "100" in found.why


@pytest.mark.parametrize("said", [{"frame": "sideways"}, {"offset_s": np.nan}])
def test_what_makes_no_sense_is_refused(said: dict[str, object]) -> None:
    with pytest.raises(InputError, match="truth"):
        aligned(exact(), exact(), **said)  # type: ignore[arg-type]
