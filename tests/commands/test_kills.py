"""SIGKILL at random moments of every command that writes: the old file or the new one."""

from __future__ import annotations

import pytest

from tests.commands.kills import main
from tests.engines import needs_compiler

KILLS = 60


@needs_compiler
@pytest.mark.slow
def test_nothing_half_written_is_read_and_nothing_old_is_lost() -> None:
    tally = main(KILLS)
    assert tally.faults == []
    assert tally.kills >= KILLS
    assert min(tally.old, tally.new) > KILLS / 10, "kills that all come too early or too late"
