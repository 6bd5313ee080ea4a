"""Claims files: what they may say, and the sentence where they may not."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmark.report.sentences import notes
from benchmark.verdicts.claims import load_claims
from models.errors import InputError
from suites.table import NAMED, find_suite

GOOD = """
[[claim]]
id = "a"
source = "ours"
says = "it is so"
criterion = "at most 1"
of = { case = ["a *", "b"], seed = [0, 1], observable = true }
at_most = 1
"""


def test_a_claim_as_written(tmp_path: Path) -> None:
    (tmp_path / "claims.toml").write_text(GOOD)
    (claim,) = load_claims(tmp_path / "claims.toml")
    assert claim.of == {"case": ("a *", "b"), "seed": (0, 1), "observable": True}
    assert (claim.value, claim.against, claim.compare) == ("rmse", None, "ratio")
    assert (claim.statistic, claim.every, claim.at_least, claim.at_most) == ("mean", (), None, 1.0)


def test_changes_of_a_criterion_have_a_day_and_a_reason(tmp_path: Path) -> None:
    change = 'changed = [{ on = 2026-11-30, why = "it could not fail" }]'
    (tmp_path / "claims.toml").write_text(GOOD + change)
    (claim,) = load_claims(tmp_path / "claims.toml")
    [found] = claim.changed
    assert (str(found.on), found.why) == ("2026-11-30", "it could not fail")
    assert notes(claim, {}) == ["Changed on 2026-11-30: it could not fail"]
    unjudged = claim.model_copy(update={"not_judged": "one run", "margin": 0.5})
    assert notes(unjudged, {})[:2] == [
        "Not judged: one run",
        "Of a single run, with a margin of 50%",
    ]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("at_most = 1\n", "", "key claim.0: Value error, neither at_least nor at_most is given"),
        ("at_most = 1", "at_most = 'one'", "key claim.0.at_most: Input should be a valid number"),
        ("id =", "name =", "key claim.0.id: Field required"),
        ("at_most = 1", "at_most = 1\nat_moost = 2", "key claim.0.at_moost: Extra inputs"),
        ("case =", "motion =", "key claim.0: Value error, column motion is unknown"),
        ("at_most = 1", 'at_most = 1\nvalue = "error"', "Value error, value error is no column"),
        ("at_most = 1", 'at_most = 1\nagainst = { pen = "b" }', "column pen is unknown"),
        ("at_most = 1", 'at_most = 1\nevery = ["seed"]', "key claim.0.every.0: Input should be"),
        ("at_most = 1", 'at_most = 1\ncompare = "less"', "key claim.0.compare: Input should be"),
        ("at_most = 1", 'at_most = 1\nstatistic = "max"', "key claim.0.statistic: Input should"),
        ("at_most = 1", "at_most = 1\nmargin = 1.0", "key claim.0.margin: Input should be less"),
        ("at_most = 1", "at_most = 1\nchanged = [{ on = 2026-11-30 }]", "changed.0.why: Field"),
        (
            "at_most = 1",
            'at_most = 1\nstatistic = "worst"\nagainst = { case = "b" }',
            "statistic worst compares nothing, expected no against",
        ),
        ("[[claim]]", "[[klaim]]", "key claim: Field required"),
        ("[[claim]]", "claim = []\n[x]", "key claim: Tuple should have at least 1 item"),
        ("of =", "of", "Expected '=' after a key in a key/value pair (at line 7"),
        ("of =", "\nsays =", "Cannot overwrite a value (at line"),
    ],
)
def test_a_wrong_file_gets_one_sentence(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    path = tmp_path / "claims.toml"
    assert GOOD.count(old) == 1
    path.write_text(GOOD.replace(old, new))
    with pytest.raises(InputError) as found:
        load_claims(path)
    assert str(found.value).startswith(f"claims file {path}: ")
    assert sentence in str(found.value)
    assert "\n" not in str(found.value)


def test_an_id_stands_once(tmp_path: Path) -> None:
    path = tmp_path / "claims.toml"
    path.write_text(GOOD + GOOD.replace('"a"', '"b"') + GOOD)
    with pytest.raises(InputError, match="id a stands twice, expected it once"):
        load_claims(path)


@pytest.mark.parametrize("name", NAMED)
def test_every_suite_has_claims_of_its_own(name: str) -> None:
    claims = load_claims(find_suite(name).claims)
    assert claims
    assert all(claim.id.startswith(f"{name}-") for claim in claims)
    where_from = ("[", "ours", "Haseltine", "do-mpc", "casadi issue")
    assert all(claim.source.startswith(where_from) for claim in claims)
