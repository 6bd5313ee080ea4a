"""What a watched run says in sentences and shades in drawings: what, of whom, when."""

from __future__ import annotations

import dataclasses

import matplotlib as mpl
import numpy as np
import pytest

mpl.use("Agg")
import matplotlib.pyplot as plt

from estimation.history import EstimateHistory
from estimation.history_plot import plot_histories
from estimation.status import Status
from estimation.watch.flags import Flag
from estimation.watch.words import FLAGGED, shaded_spans, spans, watch_sentences
from tests.benchmark.hand_made import history as hand_made

N = 100
TIMES = 0.1 * np.arange(N)
SENSORS = ("accel", "gyro", "camera")


def watched(
    statuses: dict[Status, list[slice]] | None = None,
    flags: dict[tuple[str, Flag], list[slice]] | None = None,
) -> EstimateHistory:
    """Return a history of a watched run, with what is said of some steps."""
    bare = hand_made(("tip_x_m",), TIMES, np.sin(TIMES)[:, None])
    status, flagged = list(bare.status), np.zeros((N, len(SENSORS)), dtype=np.uint8)
    for member, of_it in (statuses or {}).items():
        for rows in of_it:
            status[rows] = [each | member for each in status[rows]]
    for (name, flag), of_it in (flags or {}).items():
        for rows in of_it:
            flagged[rows, SENSORS.index(name)] |= flag.value
    return dataclasses.replace(bare, status=tuple(status), flagged=flagged, sensor_names=SENSORS)


def test_spans_end_where_something_holds_no_more() -> None:
    time_s = np.array([0.0, 1.0, 2.0, 4.0, 8.0])
    holds = np.array([True, False, True, True, False])
    np.testing.assert_array_equal(spans(time_s, holds), [[0.0, 1.0], [2.0, 8.0]])
    np.testing.assert_array_equal(spans(time_s, ~holds), [[1.0, 2.0], [8.0, 8.0]])
    assert spans(time_s, np.zeros(5, dtype=bool)).shape == (0, 2)
    assert spans(time_s[:0], holds[:0]).shape == (0, 2)


def test_a_run_says_when_it_was_lost_and_found() -> None:
    history = watched({Status.LOST: [slice(30, 52), slice(90, N)]})
    assert watch_sentences(history) == [
        "lost: from 3 s to 5.2 s, from 9 s to the end; 3.1 s in all"
    ]


def test_a_run_says_what_of_whom_and_that_noise_grew() -> None:
    often = [slice(k, k + 1) for k in (2, 12, 22, 32, 42)]
    history = watched(
        {Status.LIVELIER: [slice(60, 70)], Status.STUCK: [slice(10, 20)]},
        {
            ("camera", Flag.STUCK): [slice(10, 20)],
            ("camera", Flag.LEFT_OUT): [slice(10, 25)],
            ("accel", Flag.OUTLIER): often,
        },
    )
    assert watch_sentences(history) == [
        "livelier than the model says, process noise grew: from 6 s to 7 s",
        "accel outlier: from 0.2 s to 0.3 s, from 1.2 s to 1.3 s, from 2.2 s to 2.3 s, "
        "… 5 times; 0.5 s in all",
        "camera stuck: from 1 s to 2 s",
        "camera left out: from 1 s to 2.5 s",
    ]


def test_a_quiet_run_says_so_and_a_bare_one_nothing() -> None:
    assert watch_sentences(watched()) == ["watched: nothing was flagged, nothing was lost"]
    bare = hand_made(("tip_x_m",), TIMES, np.zeros((N, 1)))
    assert watch_sentences(bare) == []
    assert watch_sentences(watched()[:0]) == []


def test_rows_told_again_do_not_end_a_span() -> None:
    history = watched({Status.LOST: [slice(30, 52)]})
    late = history[np.concatenate([np.arange(40), [39, 39], np.arange(40, N)])]
    said = late.status[:40] + (Status.LATE,) * 2 + late.status[42:]
    assert watch_sentences(dataclasses.replace(late, status=said)) == ["lost: from 3 s to 5.2 s"]


@pytest.mark.parametrize("status", [Status.LOST, Status.INCONSISTENT, Status.LIVELIER])
def test_spans_are_shaded_and_named(status: Status) -> None:
    history = watched(
        {status: [slice(30, 52)]}, {("gyro", Flag.OUTLIER): [slice(70, 71), slice(80, 81)]}
    )
    shaded = shaded_spans(history)
    np.testing.assert_allclose(shaded[status.label], [[3.0, 5.2]])
    np.testing.assert_allclose(shaded[FLAGGED], [[7.0, 7.1], [8.0, 8.1]])
    figure = plot_histories({"watched": history})
    drawn = {each.get_label(): each for each in figure.axes[0].collections}
    assert {status.label, FLAGGED} <= set(drawn)
    corners = [np.asarray(path.vertices) for path in drawn[FLAGGED].get_paths()]
    assert [(each[:, 0].min(), each[:, 0].max()) for each in corners] == [
        pytest.approx((7.0, 7.1)),
        pytest.approx((8.0, 8.1)),
    ]
    named = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {status.label, FLAGGED} <= named
    plt.close(figure)


def test_nothing_is_shaded_where_nothing_was_said() -> None:
    assert shaded_spans(watched()) == {}
    figure = plot_histories({"watched": watched()})
    assert {text.get_text() for text in figure.legends[0].get_texts()} == {"watched", "± 2 σ"}
    plt.close(figure)
