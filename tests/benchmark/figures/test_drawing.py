"""Figures as data become drawings that show them: extremes, gaps, bands, colours, labels."""

from __future__ import annotations

import json

import numpy as np
import plotly.graph_objects
import pytest

from benchmark.figures.band import band, interval_lengths
from benchmark.figures.decimate import LIMIT, decimate
from benchmark.figures.figure import TRUTH, Figure, Line, Panel
from benchmark.figures.matplotlib_figure import matplotlib_figure
from benchmark.figures.plotly_figure import plotly_figure, plotly_layout, plotly_text
from benchmark.figures.style import NAMED, OTHERS, PAGE, THEMES, colours_of, light_to_dark


def figure(*lines: Line, columns: int = 1, panels: int = 1, **options: bool) -> Figure:
    panel = Panel("A", "time / s", "y / mm", lines, **options)
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


def test_plotly_accepts_it_and_json_has_no_nan() -> None:
    y = np.array([1.0, np.nan, np.inf, 4.0])
    line = Line("ekf", np.arange(4.0), y, std=np.ones(4), low=y - 1, high=y + 1)
    spec = plotly_figure(figure(line, panels=3, columns=2))
    plotly.graph_objects.Figure(spec)  # raises at an unknown or wrong property
    json.dumps(spec, allow_nan=False)
    traces = [trace for trace in spec["data"] if "fill" not in trace]
    assert traces[0]["y"] == [1.0, None, None, 4.0]
    assert [trace["showlegend"] for trace in traces] == [True, False, False]


def test_band_is_two_sigma_and_stops_at_gaps() -> None:
    y = np.array([1.0, 2.0, np.nan, 4.0])
    found = band(Line("ekf", np.arange(4.0), y, std=np.full(4, 0.25)))
    assert found is not None
    np.testing.assert_array_equal(found.high[[0, 1, 3]], [1.5, 2.5, 4.5])
    np.testing.assert_array_equal(found.low[[0, 1, 3]], [0.5, 1.5, 3.5])
    assert [part.x.tolist() for part in found.stretches()] == [[0.0, 1.0], [3.0]]


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
    layout = plotly_layout(figure(line, panels=4, columns=2, y_log=True))
    assert layout["xaxis3"]["matches"] == "x"
    assert layout["xaxis4"]["matches"] == "x2"
    assert "matches" not in layout["xaxis2"]
    assert not layout["xaxis"]["showticklabels"]
    assert layout["xaxis3"]["showticklabels"]
    assert layout["yaxis"]["type"] == "log"
    stacked = plotly_layout(figure(line, panels=4, columns=2), columns=1)
    assert [stacked[f"xaxis{n}"]["domain"] for n in ("", 2, 3, 4)] == [[0.0, 1.0]] * 4
    equal = plotly_layout(figure(line, panels=2, equal=True))
    assert equal["yaxis2"]["scaleanchor"] == "x2"
    assert "matches" not in equal["xaxis2"]
    own = plotly_layout(figure(line, panels=2, own_x=True))
    assert "matches" not in own["xaxis2"]
    assert own["xaxis"]["showticklabels"]


def test_plotly_takes_no_markup_from_labels() -> None:
    assert plotly_text("<b>a</b> & &lt;") == "&lt;b&gt;a&lt;/b&gt; &amp; &amp;lt;"
    text = json.dumps(plotly_figure(figure(Line("<a href='x'>", np.arange(2.0), np.arange(2.0)))))
    assert "<" not in text


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


def test_every_light_colour_has_its_own_dark_one() -> None:
    colours = (*NAMED.values(), *OTHERS)
    assert len({c.light for c in colours}) == len({c.dark for c in colours}) == len(colours)
    table = light_to_dark()
    for colour in colours:
        assert table[colour.light] == colour.dark
        assert table[colour.band("light")] == colour.band("dark")


def test_matplotlib_draws_the_same() -> None:
    x = np.linspace(1, 2, 5)
    lines = [Line("ekf", x, x, std=x / 10), Line(TRUTH, x, x, low=x - 1, high=x + 1)]
    drawing = matplotlib_figure(figure(*lines, Line("a $ b $", x, x, style="points"), panels=2))
    drawing.canvas.draw()
    first, second = drawing.axes
    assert first.get_shared_x_axes().joined(first, second)
    assert second.get_xlabel() == "time / s"
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
