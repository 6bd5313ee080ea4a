"""Quick tests leave out no value of a parameter, nor a pair of values of three parameters."""

from __future__ import annotations

from itertools import combinations, product

import pytest

from tests.cover import cover

pytest_plugins = "pytester"

PLUGIN = "from tests.conftest import pytest_collection_modifyitems  # noqa: F401\n"
TESTS = """
import pytest

@pytest.mark.cover
@pytest.mark.parametrize(
    "a, b", [(1, 1), (1, 2), (2, 1), pytest.param(2, 2, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("c", "xy")
def test_marked(a, b, c): pass

@pytest.mark.parametrize("a", [1, 2])
@pytest.mark.parametrize("c", "xy")
def test_whole(a, c): pass
"""


@pytest.mark.parametrize("sizes", [(1,), (5,), (3, 2), (2, 7), (2, 2, 2), (3, 2, 2), (2, 4, 3, 2)])
def test_every_value_and_every_pair_of_three(sizes: tuple[int, ...]) -> None:
    cases = list(product(*map(range, sizes)))
    kept = [cases[place] for place in cover(cases)]
    for width in (1, 2) if len(sizes) > 2 else (1,):
        for columns in combinations(range(len(sizes)), width):
            whole = set(product(*(range(sizes[column]) for column in columns)))
            assert {tuple(case[column] for column in columns) for case in kept} == whole
    if len(sizes) > 1:
        assert len(kept) < len(cases)


def test_a_pair_that_no_case_has_is_not_waited_for() -> None:
    assert cover([("a", 1, "x"), ("b", 2, "y")]) == [0, 1]
    assert cover([]) == []


@pytest.mark.parametrize(("options", "run"), [(["-m", "not slow"], 3 + 4), ([], 8 + 4)])
def test_only_marked_tests_of_quick_runs_are_thinned(
    pytester: pytest.Pytester, options: list[str], run: int
) -> None:
    pytester.makeconftest(PLUGIN)
    pytester.makeini("[pytest]\nmarkers =\n    slow\n    cover\n")
    pytester.makepyfile(TESTS)
    passed, skipped, failed = pytester.inline_run(
        *options, "-p", "no:cacheprovider"
    ).countoutcomes()
    assert (passed, skipped, failed) == (run, 0, 0)
