"""Who runs: the tables of contenders. A new one is a row here."""

from __future__ import annotations

from functools import partial

from benchmark.speed.contender import (
    ALGEBRA,
    BATCH,
    BUFFERS,
    CONVERGED,
    ONE_PASS,
    OVERHEAD,
    PASS_CALL,
    STEP,
    Entry,
)
from benchmark.speed.dompc_contender import DoMpc
from benchmark.speed.fatrop_contender import Fatrop
from benchmark.speed.filterpy_contender import Filterpy
from benchmark.speed.ipopt_contender import Ipopt
from benchmark.speed.osqp_contender import DEFAULT, TUNED, Osqp
from benchmark.speed.own_contenders import LIVE_HORIZON, Batch, LiveStep, WindowStep
from benchmark.speed.samples import Sample, Stream
from benchmark.speed.windows import SpeedWindow

WINDOW_CONTENDERS: tuple[Entry[SpeedWindow], ...] = (
    Entry("mhe-rti", ONE_PASS, partial(WindowStep, name="mhe-rti")),
    Entry("mhe-rti", PASS_CALL, partial(WindowStep, name="mhe-rti", call_only=True)),
    Entry("osqp", ONE_PASS, partial(Osqp, settings=DEFAULT)),
    Entry("osqp-tuned", ONE_PASS, partial(Osqp, settings=TUNED)),
    Entry("mhe", CONVERGED, partial(WindowStep, name="mhe")),
    Entry("fatrop", CONVERGED, Fatrop),
    Entry("ipopt", CONVERGED, partial(Ipopt, exact_hessian=False)),
    Entry("ipopt-exact", CONVERGED, partial(Ipopt, exact_hessian=True)),
    Entry("do-mpc", CONVERGED, DoMpc),
)
"""What solves windows."""


FILTER_HORIZON = 0
"""Of a filter: it looks back at nothing but its own state."""


def sample_contenders(dt: float) -> tuple[Entry[Sample], ...]:
    """Return what steps along a stream of constant sample time (s)."""
    return (
        Entry("ekf", STEP, partial(LiveStep, name="ekf"), horizon=FILTER_HORIZON),
        *(
            Entry(
                "filterpy",
                mode,
                partial(Filterpy, dt=dt, readings=readings),
                horizon=FILTER_HORIZON,
            )
            for mode, readings in ((STEP, "calls"), (BUFFERS, "buffers"), (ALGEBRA, "arrays"))
        ),
        *(
            Entry(
                name,
                mode,
                partial(LiveStep, name=name, overhead=mode == OVERHEAD),
                horizon=LIVE_HORIZON,
                judged=False,
            )
            for name in ("mhe-rti", "mhe")
            for mode in (STEP, OVERHEAD)
        ),
    )


def stream_contenders(samples: int) -> tuple[Entry[Stream], ...]:
    """Return what takes a whole stream of some samples in one call."""
    build = {name: partial(Batch, name=name) for name in ("ekf", "mhe-rti", "mhe")}
    return (
        Entry("ekf", BATCH, build["ekf"], samples, FILTER_HORIZON),
        *(
            Entry(name, BATCH, build[name], samples, LIVE_HORIZON, judged=False)
            for name in ("mhe-rti", "mhe")
        ),
    )
