"""Machine code is the same function; without a compiler the function itself is used."""

from __future__ import annotations

import subprocess
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from ekf_baseline.ekf import Ekf
from estimation import native
from estimation.function_call import FunctionCall
from estimation.symbolic_stage import predict_function, update_function
from mhe.config import MheConfig, MheRtiConfig
from mhe.realtime import Mhe, MheRti
from tests.closeness import estimate_error
from tests.engines import needs_compiler, steps
from tests.estimation.pens import draw_pen_run


def small_function(factor: float = 2.0) -> ca.Function:
    x = ca.SX.sym("x", 3)
    return ca.Function("small", [x], [factor * ca.sin(x) / ca.sumsqr(x)])


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PEN_MHE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def no_compiler(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("PATH", "/nonexistent")
    monkeypatch.delenv("CC", raising=False)
    native.compiler.cache_clear()
    yield
    native.compiler.cache_clear()


@pytest.mark.usefixtures("no_compiler", "own_cache")
def test_without_a_compiler_the_function_itself_comes_back_with_one_warning() -> None:
    function = small_function()
    with pytest.warns(RuntimeWarning, match="no C compiler") as caught:
        results = [native.compiled(function) for _ in range(3)]
    assert [result is function for result in results] == [True] * 3
    assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert native.compiled(function) is function


@needs_compiler
def test_estimators_without_a_compiler_say_so_once_and_give_the_same(
    request: pytest.FixtureRequest,
) -> None:
    run = draw_pen_run(10, 6)
    builds: list[Callable[[], Any]] = [
        lambda: Ekf(run.model),
        lambda: MheRti(run.model, MheRtiConfig(horizon=3)),
        lambda: Mhe(run.model, MheConfig(horizon=3)),
    ]
    compiled = [build() for build in builds]
    request.getfixturevalue("no_compiler")
    with pytest.warns(RuntimeWarning, match="no C compiler") as caught:
        interpreted = [build() for build in builds]
    assert len(caught) == 1
    for machine, plain in zip(compiled, interpreted, strict=True):
        for a, b in zip(
            steps(machine, run.measurements), steps(plain, run.measurements), strict=True
        ):
            assert estimate_error(run.model, a, b) < 1e-9


@needs_compiler
@pytest.mark.usefixtures("optimised")
def test_compiled_equals_interpreted_on_the_pens_stage() -> None:
    run = draw_pen_run(6, 6)
    model, rng = run.model, np.random.default_rng(3)
    root = np.tril(rng.uniform(-0.1, 0.1, (15, 15))) + np.eye(15)
    P, x = root @ root.T, model.prior.mean
    y = np.nan_to_num(run.measurements[1].y)
    present = ~np.isnan(np.delete(run.measurements[1].y, 11))
    cases = [
        (predict_function(model), (x + 0.1, P, x, rng.standard_normal(15), 0.013, np.ones(15))),
        (update_function(model), (x + 0.1, P, x, y, present)),
    ]
    for function, arguments in cases:
        machine = FunctionCall(native.compiled(function))
        plain = FunctionCall(function)
        assert not machine.function.is_a("SXFunction")
        for result, wanted in zip(machine(*arguments), plain(*arguments), strict=True):
            scale = 1 + np.abs(wanted).max()
            assert np.abs(result - wanted).max() < 1e-12 * scale
            assert np.isfinite(wanted).all()


@needs_compiler
def test_cache_is_used_again_and_told_apart_by_content(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = np.array([0.1, 0.2, 0.3])
    first = np.asarray(native.compiled(small_function())(x)).ravel()
    assert len(list(own_cache.glob("*.so"))) == 1
    other = np.asarray(native.compiled(small_function(3.0))(x)).ravel()
    assert len(list(own_cache.glob("*.so"))) == 2
    np.testing.assert_allclose(other, 1.5 * first, rtol=1e-14)

    def refuse(*_: object, **__: object) -> None:
        pytest.fail("the compiler was called for a function that is in the cache")

    monkeypatch.setattr(subprocess, "run", refuse)
    again = np.asarray(native.compiled(small_function())(x)).ravel()
    np.testing.assert_array_equal(again, first)
    assert sorted(path.suffix for path in own_cache.iterdir()) == [".so", ".so"]


@needs_compiler
@pytest.mark.usefixtures("own_cache")
def test_a_compiler_that_fails_says_so() -> None:
    with pytest.raises(RuntimeError, match="could not compile"):
        native.shared_libraries([native.CSource("this is not C")])


@pytest.mark.usefixtures("own_cache")
def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert native.cache_directory() == tmp_path / "cache"
    monkeypatch.delenv("PEN_MHE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert native.cache_directory() == tmp_path / "xdg" / "pen-mhe"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert native.cache_directory() == Path.home() / ".cache" / "pen-mhe"
