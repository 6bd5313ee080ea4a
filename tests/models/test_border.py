"""The border of a reader, and what a sentence says of values."""

from __future__ import annotations

import pytest

from models.border import reading
from models.errors import InputError, UnforeseenError
from models.parsed import check_entries, json_data, toml_data
from models.shown_text import LONGEST_VALUE, one_line, short, value_text


def test_what_no_check_foresaw_keeps_its_cause() -> None:
    fault = ZeroDivisionError("a fault\nof \x1b[31mours")
    with pytest.raises(UnforeseenError) as caught, reading("pen file a.toml", "TOML"):
        raise fault
    assert caught.value.__cause__ is fault
    expected = r"ZeroDivisionError: a fault of \x1b[31mours"
    assert str(caught.value) == f"pen file a.toml: cannot be read ({expected}), expected TOML"


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (InputError("as it is"), "^as it is$"),
        (MemoryError(), "needs more memory than there is"),
        (RecursionError(), "is nested too deeply"),
        (PermissionError(13, "Permission denied"), "f: Permission denied, expected g"),
    ],
)
def test_what_is_foreseen(fault: Exception, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught, reading("f", "g"):
        raise fault
    assert not isinstance(caught.value, UnforeseenError)


@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit, GeneratorExit])
def test_who_ends_the_process_ends_it(end: type[BaseException]) -> None:
    with pytest.raises(end), reading("f", "g"):
        raise end


def test_values_are_one_short_line() -> None:
    assert one_line("a\n b\tc") == "a b c"
    assert one_line("\x1b]0;x\x07\u202e") == r"\x1b]0;x\x07\u202e"
    assert short("winkel_α") == "winkel_α"
    for value in ("x" * 10**6, ["y" * 500] * 9, b"z" * 999, "\n" * 10**5):
        for text in (value_text(value), short(value)):
            assert len(text) <= LONGEST_VALUE + 1
            assert text.isprintable()
    assert value_text(1 << 10**5) == "a int that is too large to show"
    assert len(str(InputError("a" * 10**5))) == 3000


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = 0x" + "f" * 99_000, "key a: a whole number of 396000 bits, expected one that fits"),
        ("a = " + "9" * 99_000, "Exceeds the limit"),
        ("b.c = -9223372036854775808", ""),
        ("b = {c = [1, 9223372036854775808]}", "key b.c: a whole number of 64 bits"),
        ("a = " + "[" * 31 + "]" * 31, ""),
        ("a = " + "[" * 32 + "]" * 32, "33 tables or lists within each other"),
        ("a = " + "[" * 99_000, "nested too deeply"),
        ("a." * 90_000 + "b = 1", "90001 tables or lists within each other"),
        ('a = "' + "b." * 100 + '"\n# ' + "c." * 100, ""),
        ("a." * 31 + "b = 1", ""),
        ("a." * 32 + "b = 1", "33 tables or lists within each other"),
        ('"' + '\\"' * 90_000, "TOML"),
    ],
)
def test_toml(text: str, said: str) -> None:
    if said:
        with pytest.raises(InputError, match=said):
            toml_data(text, "f")
    else:
        toml_data(text, "f")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[" * 10**6, "1000000 tables or lists within each other"),
        ('{"a": [' * 40, "80 tables or lists within each other"),
        ('["[[[[\\"[[["]' + " " * 90, ""),
        ("9" * 300, "a number at byte 0 has 300 digits or more"),
        ("[1,", "Expecting value"),
        ('"\ud800"', "surrogates|utf-8"),
    ],
)
def test_json(text: str, said: str) -> None:
    data = text.encode("utf-8", "surrogatepass")
    if said:
        with pytest.raises(InputError, match=said):
            json_data(data, "f")
    else:
        assert json_data(data, "f") == ['[[[["[[[']


def test_entries_are_what_they_should_be() -> None:
    kinds: dict[str, tuple[type, type | None]] = {"suites": (list, str), "seeds": (int, None)}
    check_entries({"suites": ["a"], "other": 1}, kinds, "run.json")
    with pytest.raises(InputError, match=r"run\.json: key suites: 5, expected list of str"):
        check_entries({"suites": 5}, kinds, "run.json")
    with pytest.raises(InputError, match=r"key suites: \['a', 5\], expected list of str"):
        check_entries({"suites": ["a", 5]}, kinds, "run.json")
