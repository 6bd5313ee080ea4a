"""Figures as data become drawings that show them: extremes, gaps, bands, colours, labels."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from benchmark.figures.band import band, interval_lengths
from benchmark.figures.chart import PLAIN, STEPS, chart, packed
from benchmark.figures.decimate import LIMIT, decimate
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.figures.matplotlib_figure import matplotlib_figure
from benchmark.figures.style import (
    MARKS,
    NAMED,
    OTHERS,
    PAGE,
    THEMES,
    Stroke,
    colours_of,
    stroke_of,
)


def figure(*lines: Line, columns: int = 1, panels: int = 1, **options: bool) -> Figure:
    panel = Panel("A", "time (s)", "y (mm)", lines, **options)
    return Figure("key", "Title", "Caption.", [panel] * panels, columns)


def test_decimation_keeps_extremes_and_gaps() -> None:
    rng = np.random.default_rng(1)
    y = rng.normal(size=50_000)
    y[12_345], y[23_456] = 50.0, -60.0
    y[30_000:30_100] = np.nan
    kept = decimate(y)
    assert len(kept) <= LIMIT + 8
    assert {0, 12_345, 23_456, 29_999, 30_000, 30_099, 30_100, 49_999} <= set(kept.tolist())
    assert np.all(np.diff(kept) > 0)


def test_decimation_keeps_extremes_of_every_curve_of_every_bin() -> None:
    x, y = np.cos(np.linspace(0, 60, 9000)), np.sin(np.linspace(0, 77, 9000))
    kept = decimate(x, y)
    bins = np.array_split(np.arange(9000), LIMIT // 4)
    for curve in (x, y):
        for part in bins:
            inside = curve[kept[(kept >= part[0]) & (kept <= part[-1])]]
            assert inside.min() == curve[part].min()
            assert inside.max() == curve[part].max()


def test_short_curve_stays_whole() -> None:
    assert decimate(np.full(LIMIT, np.nan)).tolist() == list(range(LIMIT))


def unpacked(told: list[float | None] | dict[str, Any]) -> np.ndarray:
    """As ``chart.js`` reads numbers."""
    if isinstance(told, list):
        return np.array([np.nan if v is None else v for v in told])
    steps = np.array([np.nan if v is None else v for v in told["d"]])
    values = told["o"] + told["s"] * np.where(np.isnan(steps), np.nan, np.nancumsum(steps))
    return np.asarray(10**values) if told.get("log") else values


def test_json_has_no_nan_and_gaps_are_null() -> None:
    y = np.array([1.0, np.nan, np.inf, 4.0])
    line = Line("ekf", np.arange(4.0), y, std=np.ones(4), low=y - 1, high=y + 1)
    spec = chart(figure(line, panels=3, columns=2))
    json.dumps(spec, allow_nan=False)
    for panel in spec["panels"]:
        (told,) = panel["lines"]
        assert told["y"] == [1.0, None, None, 4.0]
        assert told["band"][1] == [3.0, None, None, 6.0]
        assert told["bars"] == [[0.0, None, None, 3.0], [2.0, None, None, 5.0]]


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("origin", [0.0, 300.0])
def test_a_long_curve_is_told_to_less_than_a_pixel(log: bool, origin: float) -> None:
    rng = np.random.default_rng(3)
    y = origin + np.exp(rng.normal(size=500).cumsum() / 5)
    y[100:120] = np.nan
    y[7] = np.inf
    assert len(y) > PLAIN
    told = packed(y, log)
    assert isinstance(told, dict)
    json.dumps(told, allow_nan=False)
    seen = np.isfinite(y)
    found = unpacked(told)
    assert np.array_equal(np.isfinite(found), seen)
    drawn = np.log10 if log else np.asarray
    error = np.abs(drawn(found[seen]) - drawn(y[seen]))
    assert error.max() <= np.ptp(drawn(y[seen])) / STEPS
    assert len(json.dumps(told)) < 0.4 * len(json.dumps(y.tolist()))


def test_a_long_curve_of_one_value_or_none() -> None:
    np.testing.assert_array_equal(unpacked(packed(np.full(99, 2.5))), np.full(99, 2.5))
    assert packed(np.full(99, np.nan)) == [None] * 99
    assert packed(np.full(99, -1.0), log=True) == [None] * 99


def test_band_is_two_sigma_and_stops_at_gaps() -> None:
    y = np.array([1.0, 2.0, np.nan, 4.0])
    found = band(Line("ekf", np.arange(4.0), y, std=np.full(4, 0.25)))
    assert found is not None
    np.testing.assert_array_equal(found.high[[0, 1, 3]], [1.5, 2.5, 4.5])
    np.testing.assert_array_equal(found.low[[0, 1, 3]], [0.5, 1.5, 3.5])
    assert [part.x.tolist() for part in found.stretches()] == [[0.0, 1.0], [3.0]]


def test_a_band_of_its_own_takes_the_place_of_two_sigma() -> None:
    y = np.array([1.0, 2.0])
    line = Line("ekf", y, y, std=y, band=(y - 0.5, y + 3.0))
    found = band(line)
    assert found is not None
    np.testing.assert_array_equal([found.low, found.high], [[0.5, 1.5], [4.0, 5.0]])
    (panel,) = chart(figure(line))["panels"]
    assert panel["lines"][0]["band"] == [[0.5, 1.5], [4.0, 5.0]]


def test_band_on_a_logarithmic_axis_stays_positive() -> None:
    line = Line("ekf", np.arange(2.0), np.array([1.0, 1.0]), std=np.array([0.1, 5.0]))
    found = band(line, y_log=True)
    assert found is not None
    np.testing.assert_allclose(found.low, [0.8, 0.1])


def test_error_bars_reach_to_the_interval() -> None:
    y = np.array([1.0, 2.0])
    lengths = interval_lengths(
        Line("ekf", y, y, low=np.array([0.5, np.nan]), high=np.array([3.0, np.inf]))
    )
    assert lengths is not None
    assert lengths[0].tolist() == [0.5, 0.0]
    assert lengths[1].tolist() == [2.0, 0.0]


def test_axes_are_shared_within_a_column_logarithmic_and_equal() -> None:
    line = Line("ekf", np.arange(3.0), np.arange(3.0) + 1)

    def told(key: str, panels: int, columns: int = 1, **options: bool) -> list[object]:
        return [
            p[key] for p in chart(figure(line, panels=panels, columns=columns, **options))["panels"]
        ]

    assert told("shares", 4, 2) == [0, 1, 0, 1]
    # wide, and all below each other on a phone
    assert told("labelled", 4, 2) == [[False, True], [False, True], [True, True], [True, True]]
    assert told("labelled", 2) == [[False, False], [True, True]]
    assert told("logs", 1, y_log=True) == [[False, True]]
    assert told("shares", 2, equal=True) == told("shares", 2, own_x=True) == [0, 1]
    assert told("labelled", 2, own_x=True) == [[True, True], [True, True]]


def test_lines_differ_without_their_colours() -> None:
    strokes = [stroke_of(colour) for name, colour in NAMED.items() if name != TRUTH]
    strokes += [stroke_of(colour) for colour in OTHERS]
    assert sorted(stroke.mark for stroke in strokes) == sorted(MARKS)
    assert stroke_of(NAMED[TRUTH]) == Stroke()
    estimators = [stroke_of(NAMED[name]).dash for name in ("ekf", "mhe-rti", "mhe", "mhe-sparse")]
    assert len(set(estimators)) == len(estimators)
    assert stroke_of(NAMED["ekf"], "dashed").dash


def test_a_name_has_one_colour_and_neighbours_differ() -> None:
    y = np.arange(2.0)
    names = ["ekf", TRUTH, *(f"sensor {n}" for n in range(len(OTHERS)))]
    both = [figure(*(Line(n, y, y) for n in names)), figure(Line("sensor 3", y, y))]
    found = colours_of(both)
    assert found["ekf"] == NAMED["ekf"]
    assert len({found[name] for name in names}) == len(names)
    assert list(found) == names


@pytest.mark.parametrize("theme", THEMES)
def test_lines_and_text_stand_out_from_the_paper(theme: str) -> None:
    paper = PAGE["paper"]
    for colour in (*NAMED.values(), *OTHERS):
        assert contrast(getattr(colour, theme), getattr(paper, theme)) >= 3.0
    for name in ("ink", "muted", "link", "good", "bad", "open"):
        for under in ("paper", "raised"):
            assert contrast(getattr(PAGE[name], theme), getattr(PAGE[under], theme)) >= 4.5
    for level in range(5):
        shade = getattr(PAGE[f"level-{level}"], theme)
        assert contrast(getattr(PAGE["ink"], theme), shade) >= 4.5


def test_every_colour_is_there_once() -> None:
    colours = (*NAMED.values(), *OTHERS)
    assert len({c.light for c in colours}) == len({c.dark for c in colours}) == len(colours)


def test_no_line_takes_the_colour_of_the_truth() -> None:
    y = np.arange(2.0)
    many = figure(*(Line(f"line {n}", y, y) for n in range(40)))
    assert NAMED[TRUTH] not in colours_of([many]).values()


# As somebody sees who has no cones for green: Vienot, Brettel and Mollon (1999).
DEUTERANOPIA = np.array(
    [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]]
)


@pytest.mark.parametrize("theme", THEMES)
def test_estimators_differ_without_cones_for_green(theme: str) -> None:
    seen = {}
    for name in ("ekf", "mhe-rti", "mhe", TRUTH):
        colour = getattr(NAMED[name], theme)
        parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        seen[name] = np.clip(DEUTERANOPIA @ linear, 0, 1) ** (1 / 2.2)
    names = list(seen)
    apart = [np.linalg.norm(seen[a] - seen[b]) for a in names for b in names if a < b]
    assert min(apart) > 0.15


def test_matplotlib_draws_the_same() -> None:
    x = np.linspace(1, 2, 5)
    lines = [Line("ekf", x, x, std=x / 10), Line(TRUTH, x, x, low=x - 1, high=x + 1)]
    drawing = matplotlib_figure(figure(*lines, Line("a $ b $", x, x, style="points"), panels=2))
    drawing.canvas.draw()
    first, second = drawing.axes
    assert first.get_shared_x_axes().joined(first, second)
    assert second.get_xlabel() == "time (s)"
    assert first.lines[0].get_color() == NAMED["ekf"].light
    assert [text.get_text() for text in drawing.legends[0].get_texts()][:2] == ["ekf", TRUTH]


def contrast(one: str, other: str) -> float:
    """Contrast ratio of WCAG 2.2."""
    lighter, darker = sorted((luminance(one), luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def luminance(colour: str) -> float:
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return sum(w * p for w, p in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_a_panel_of_one_value_has_the_axis_of_its_neighbour() -> None:
    x = np.arange(4.0)
    panels = [
        Panel("some", "x", "share (%)", [Line("ekf", x, 10 * x)]),
        Panel("none", "x", "share (%)", [Line("ekf", x, 0 * x)]),
    ]
    drawing = matplotlib_figure(Figure("key", "Title", "", panels, columns=2))
    assert drawing.axes[1].get_ylim() == drawing.axes[0].get_ylim()


@pytest.mark.parametrize("ends", [(0.62, 0.68), (0.06, 0.3), (3.0, 40.0), (1e-3, 1e4)])
def test_a_logarithmic_axis_has_labels(ends: tuple[float, float]) -> None:
    x = np.linspace(*ends, 5)
    drawing = matplotlib_figure(figure(Line("ekf", x, x), y_log=True))
    drawing.canvas.draw()
    (axes,) = drawing.axes
    low, high = axes.get_ylim()
    seen = [
        label.get_text()
        for label in axes.get_yticklabels()
        if low <= label.get_position()[1] <= high
    ]
    assert len([text for text in seen if text]) >= 2
