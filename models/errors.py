"""The one exception for input that a person can mend."""

from __future__ import annotations


class InputError(ValueError):
    """Bad input: one sentence that says what, where, and what was expected."""
