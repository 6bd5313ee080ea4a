"""Every outcome has a sentence and a label that leads back to it."""

from __future__ import annotations

import itertools

import pytest

from estimation.status import SENTENCES, UNSOLVED, Status

PAIRS = [one | other for one, other in itertools.combinations(Status, 2)]


def from_label(label: str) -> Status:
    status = Status.SOLVED
    for part in label.split("+"):
        status |= Status[part.upper()]
    return status


@pytest.mark.parametrize("status", [Status.SOLVED, *Status])
def test_every_member_has_one_sentence_of_its_own(status: Status) -> None:
    sentence = SENTENCES[status]
    assert status.sentence == sentence
    assert sentence.endswith(".")
    assert sentence.count(".") == 1
    assert list(SENTENCES.values()).count(sentence) == 1


def test_labels_lead_back() -> None:
    for status in (Status.SOLVED, *Status, *PAIRS):
        assert from_label(status.label) is status
        assert status.label == status.label.lower()


def test_a_pair_says_both_sentences_and_is_solved_if_both_are() -> None:
    for status in PAIRS:
        one, other = list(status)
        assert status.sentence == f"{one.sentence} {other.sentence}"
        assert status.is_solved == (one.is_solved and other.is_solved)


def test_what_counts_as_unsolved() -> None:
    remarks = {
        Status.NO_READING,
        Status.LATE,
        Status.INFINITE_READING,
        Status.SATURATED,
        Status.GATED,
        Status.NEAR_SINGULAR,
        Status.OUT_OF_REACH,
        Status.FELL_BACK,
        Status.IMPROBABLE,
        Status.DIGITS_LOST,
        Status.STUCK,
        Status.OUTLIER,
        Status.LIVELIER,
    }
    assert set(Status) - set(UNSOLVED) == remarks
    assert Status.SOLVED.is_solved
    assert not any(status.is_solved for status in UNSOLVED)
