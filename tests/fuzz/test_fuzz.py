"""Every reader takes what it is given, or refuses it in one sentence: a small budget, always same.

`make fuzz` goes on from here, guided by coverage.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from models.errors import InputError
from models.parsed import json_data, toml_data
from tests.fuzz.mutators import mutated
from tests.fuzz.seeds import CORPUS, seeds
from tests.fuzz.targets import TARGETS, FindingError, check, checked

EXAMPLES = 25
MAKEFILE = Path(__file__).resolve().parents[2] / "Makefile"
texts = st.text(max_size=40)


@pytest.mark.parametrize("target", TARGETS)
def test_seeds_and_what_was_found_once(target: str) -> None:
    for data in seeds(target):
        check(target, data)
    TARGETS[target](seeds(target)[0])


@pytest.mark.parametrize("target", TARGETS)
@seed(20)
@settings(
    max_examples=EXAMPLES,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(draw=st.randoms(use_true_random=False))
def test_changed_files(target: str, draw: random.Random) -> None:
    check(target, mutated(draw.choice(seeds(target)), draw))


def test_make_fuzz_knows_every_reader_and_the_corpus_no_other() -> None:
    listed = re.search(r"^FUZZ \?= (.*)$", MAKEFILE.read_text(), re.MULTILINE)
    assert listed is not None
    assert listed[1].split() == list(TARGETS)
    assert {path.name for path in CORPUS.iterdir()} <= set(TARGETS)


def test_a_finding_is_found() -> None:
    error = InputError("fine")
    error.args = ("two\nlines",)
    with pytest.raises(FindingError, match="not one printable line"), checked():
        raise error
    with pytest.raises(KeyError), checked():
        raise KeyError("ours")


@seed(20)
@settings(max_examples=100, deadline=None, database=None)
@given(texts)
def test_any_text_as_toml_and_json(text: str) -> None:
    for parse in (lambda: toml_data(text, "f"), lambda: json_data(text.encode(), "f")):
        with checked():
            parse()
