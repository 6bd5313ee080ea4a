"""Names that a person types, and what stands in a sentence beside one that is unknown."""

from __future__ import annotations

from collections.abc import Iterable

from models.errors import InputError
from models.shown_text import short

SIMILARITY = 0.6
"""From which ratio of `difflib` on a name is taken for a misspelt one; larger guesses less."""
LONGEST_TYPED = 100
"""Characters of a name that somebody may have mistyped; a longer one takes long to compare."""


def unknown(kind: str, name: object, known: Iterable[str]) -> InputError:
    """Return the error of a name that nothing has.

    Parameters
    ----------
    kind : of what is named: ``motion``
    name : as it was typed
    known : the names that there are
    """
    return InputError(
        f"{kind} {short(name) or repr(name)} is unknown, {expected_one_of(name, known)}"
    )


def expected_one_of(name: object, known: Iterable[str]) -> str:
    """Return the end of a sentence: all names that there are, and the one that was meant."""
    names = tuple(known)
    return f"expected one of {', '.join(names)}{did_you_mean(name, names)}"


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """Return ``; did you mean gyro?`` for the known name nearest to a name, else nothing."""
    found = nearest(str(name), known)
    return "" if found is None else f"; did you mean {found}?"


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is spelt most alike, or begins or ends alike; None without one.

    Capital letters do not count: ``EKF`` is ``ekf``.
    """
    from difflib import get_close_matches  # only where somebody mistyped

    if len(name) > LONGEST_TYPED:
        return None
    spelt = {one.casefold(): one for one in known}
    typed = name.casefold()
    alike = get_close_matches(typed, spelt, n=1, cutoff=SIMILARITY)
    # ``gyroscope`` for ``gyro`` is longer by too much for the ratio, and so is ``dp``.
    longer = (one for one in spelt if typed and one and (one in typed or typed in one))
    found = alike[0] if alike else next((one for one in longer if _shares_an_end(one, typed)), None)
    return None if found is None else spelt[found]


def _shares_an_end(one: str, other: str) -> bool:
    short, long = sorted((one, other), key=len)
    return len(short) >= 2 and (long.startswith(short) or long.endswith(short))


def several(names: Iterable[str]) -> tuple[str, ...]:
    """Return names as a tuple; a text alone is one name, not its letters."""
    return (names,) if isinstance(names, str) else tuple(names)
