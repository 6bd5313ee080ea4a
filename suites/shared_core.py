"""Times that were measured beside other work: too long, so no claim counts them."""

from __future__ import annotations

import math
import time

from benchmark.tasks.task import OK

SHARED_CORE = "shared core"
"""Status of a task that had less than `LEAST_SHARE` of a core while it measured."""
LEAST_SHARE = 0.95


class CoreClock:
    """What part of a core is this process's, from here on."""

    def __init__(self) -> None:
        self._began_s, self._used_s = time.perf_counter(), time.process_time()

    def share(self) -> float:
        """Return the part so far: what is missing to 1 went to other work."""
        return (time.process_time() - self._used_s) / (time.perf_counter() - self._began_s)


def judged(share: float) -> tuple[str, str]:
    """Return the status of what was measured with a part of a core, and why it is not `OK`."""
    if share >= LEAST_SHARE:
        return OK, ""
    # Rounded down: 94.9 % is not 95 %.
    return SHARED_CORE, f"only {math.floor(100 * share)} % of a core"
