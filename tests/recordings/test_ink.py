"""The ink measure on scans whose ink is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from models.errors import InputError
from recordings.ink import (
    INCH_MM,
    RESAMPLING_MM,
    TRIMMED_SAMPLES,
    ink_points_mm,
    match_ink,
    otsu_threshold,
    written_path_mm,
)
from recordings.ink_map import InkMap

Image = pytest.importorskip("PIL.Image", reason="the extra [scan] is not installed")


def brute_force_otsu(grey: np.ndarray) -> int:
    """Otsu's definition, written as a loop over thresholds."""
    best, best_level = -1.0, 0
    for level in range(256):
        low, high = grey[grey <= level], grey[grey > level]
        if low.size and high.size:
            between = low.size * high.size * (low.mean() - high.mean()) ** 2
            if between > best * (1 + 1e-12):
                best, best_level = between, level
    return best_level


@pytest.mark.parametrize("seed", range(5))
def test_otsu_equals_its_definition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dark = rng.normal(60, 20, 400).clip(0, 255)
    light = rng.normal(200, 15, 3000).clip(0, 255)
    grey = np.concatenate([dark, light]).astype(np.uint8)
    assert otsu_threshold(grey) == brute_force_otsu(grey.astype(float))


def zigzag(n: int = 2000) -> np.ndarray:
    """A path (n, 2) in mm around a centre: none of it is far enough to be dropped as a speck."""
    s = np.linspace(0, 2 * np.pi, n)
    radius = 20 + 3 * np.sin(7 * s) + 2 * np.abs(np.sin(11 * s + s**2))
    return np.column_stack([radius * np.cos(s), radius * np.sin(s)])


def draw(path_mm: np.ndarray, file: Path, dpi: int = 300) -> None:
    """Draw a path as dark pixels on a light sheet, y upwards, 10 mm from the corner."""
    dense = np.column_stack(
        [np.interp(np.linspace(0, 1, 40000), np.linspace(0, 1, len(path_mm)), c) for c in path_mm.T]
    )
    pixels = np.round((dense - path_mm.min(axis=0) + 10) * dpi / INCH_MM).astype(int)
    sheet = np.full((pixels[:, 1].max() + 120, pixels[:, 0].max() + 120), 230, np.uint8)
    sheet[sheet.shape[0] - 1 - pixels[:, 1], pixels[:, 0]] = 30
    Image.fromarray(sheet).save(file, dpi=(dpi, dpi))


def test_a_path_on_its_own_ink_has_distance_below_a_pixel(tmp_path: Path) -> None:
    path = zigzag()
    draw(path, tmp_path / "scan.png")
    ink = ink_points_mm(tmp_path / "scan.png")
    match = match_ink(path + np.array([150.0, -80.0]), InkMap(ink))
    assert match.mean_distance_mm < INCH_MM / 300
    assert np.abs(np.diff(match.path_mm - path, axis=0)).max() < 1e-9  # a shift, nothing else


def test_a_part_of_the_path_finds_its_place(tmp_path: Path) -> None:
    path = zigzag()
    draw(path, tmp_path / "scan.png")
    part = path[1200:1700]
    match = match_ink(part - 40.0, InkMap(ink_points_mm(tmp_path / "scan.png")))
    assert match.mean_distance_mm < INCH_MM / 300


def test_known_distance(tmp_path: Path) -> None:
    # Ink: a horizontal line. Path: two parallel lines 1 mm apart, so 0.5 mm from it at best.
    ink = np.column_stack([np.arange(0, 50, 0.02), np.zeros(2500)])
    x = np.arange(5, 45, 0.5)
    path = np.vstack([np.column_stack([x, np.full_like(x, y)]) for y in (-0.5, 0.5)])
    assert match_ink(path, InkMap(ink)).mean_distance_mm == pytest.approx(0.5, abs=1e-3)


def test_far_specks_are_not_ink(tmp_path: Path) -> None:
    draw(zigzag(), tmp_path / "scan.png")
    clean = ink_points_mm(tmp_path / "scan.png")
    with Image.open(tmp_path / "scan.png") as image:
        sheet = np.array(image)
    wide = np.full((sheet.shape[0], sheet.shape[1] + 3000), 230, np.uint8)
    wide[:, : sheet.shape[1]] = sheet
    wide[5:15, -10:] = 0
    Image.fromarray(wide).save(tmp_path / "specks.png", dpi=(300, 300))
    assert ink_points_mm(tmp_path / "specks.png")[:, 0].max() == pytest.approx(
        clean[:, 0].max(), abs=1e-9
    )


def test_a_scan_without_resolution_is_refused(tmp_path: Path) -> None:
    Image.fromarray(np.zeros((9, 9), np.uint8)).save(tmp_path / "scan.png")
    with pytest.raises(InputError, match=r"scan\.png: no resolution .* expected dpi"):
        ink_points_mm(tmp_path / "scan.png")


def test_written_path_keeps_pressed_parts_at_even_spacing() -> None:
    n = 1000
    x_m = np.linspace(0, 0.1, n)
    pressed = (np.arange(n) > n // 2).astype(float)
    path = written_path_mm(np.column_stack([x_m, np.zeros(n)]), pressed)
    np.testing.assert_allclose(np.diff(path[:, 0]), RESAMPLING_MM, atol=1e-9)
    assert path[0, 0] >= 1e3 * x_m[n // 2]
    assert path[-1, 0] <= 1e3 * x_m[n - TRIMMED_SAMPLES]


def test_a_path_that_is_too_short_is_refused() -> None:
    with pytest.raises(InputError, match="path of 100 samples is too short"):
        written_path_mm(np.zeros((100, 2)), np.ones(100))
