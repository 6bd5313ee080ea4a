"""Who runs: the tables of contenders. A new one is a row here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from suites.speed.acados_contender import Acados
from suites.speed.acados_settings import ACADOS, ACADOS_TUNED
from suites.speed.contender import (
    ALGEBRA,
    BATCH,
    BUFFERS,
    COLD_CALL,
    CONVERGED,
    CONVERGED_CALL,
    EXPORTED,
    EXPORTED_FLOAT,
    FULL_STREAM_CALL,
    ONE_PASS,
    OVERHEAD,
    PASS_CALL,
    STEP,
    STREAM_CALL,
    Contender,
    Entry,
)
from suites.speed.dompc_contender import DoMpc
from suites.speed.exported_contender import ExportedStep
from suites.speed.fatrop_contender import Fatrop
from suites.speed.filterpy_contender import Filterpy
from suites.speed.ipopt_contender import Ipopt
from suites.speed.osqp_contender import DEFAULT, RHOS, TUNED, TUNED_BOUNDED, Osqp
from suites.speed.own_contenders import LIVE, LIVE_HORIZON, Batch, LiveStep, WindowStep
from suites.speed.qp_contenders import Clarabel, Piqp, Qpalm
from suites.speed.samples import Sample, SampleStream
from suites.speed.windows import SpeedWindow

QP_CONTENDERS: Mapping[str, Callable[..., Contender[SpeedWindow]]] = MappingProxyType(
    {
        "osqp": partial(Osqp, settings=DEFAULT, bounded_settings=DEFAULT),
        "osqp-tuned": partial(
            Osqp, settings=TUNED, bounded_settings=TUNED_BOUNDED, bounded_rhos=RHOS
        ),
    }
)
"""What solves one Gauss-Newton step as a QP; each also tells the time of its compiled calls."""

CALLS = ((PASS_CALL, False), (COLD_CALL, True))
"""Compiled calls of one pass: right after another window, and with cold caches."""

WINDOW_CONTENDERS: tuple[Entry[SpeedWindow], ...] = (
    Entry("mhe-rti", ONE_PASS, partial(WindowStep, name="mhe-rti")),
    *(
        Entry("mhe-rti", mode, partial(WindowStep, name="mhe-rti", call_only=True), is_cold=cold)
        for mode, cold in CALLS
    ),
    *(
        Entry(name, mode, partial(build, call_only=mode == PASS_CALL))
        for name, build in QP_CONTENDERS.items()
        for mode in (ONE_PASS, PASS_CALL)
    ),
    Entry("clarabel", ONE_PASS, Clarabel),
    Entry("piqp", ONE_PASS, Piqp),
    Entry("qpalm", ONE_PASS, Qpalm),
    *(
        Entry(
            name,
            mode,
            partial(Acados, settings=settings, call_only=mode != ONE_PASS),
            is_cold=mode == COLD_CALL,
        )
        for name, settings in (("acados", ACADOS), ("acados-tuned", ACADOS_TUNED))
        for mode in (ONE_PASS, *dict(CALLS))
    ),
    Entry("mhe", CONVERGED, partial(WindowStep, name="mhe")),
    Entry("mhe", CONVERGED_CALL, partial(WindowStep, name="mhe", call_only=True)),
    Entry("fatrop", CONVERGED, Fatrop),
    *(
        Entry(name, mode, partial(Ipopt, exact_hessian=exact, call_only=mode == CONVERGED_CALL))
        for name, exact in (("ipopt", False), ("ipopt-exact", True))
        for mode in (CONVERGED, CONVERGED_CALL)
    ),
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
                partial(LiveStep, name=name, counted=mode),
                horizon=LIVE_HORIZON,
                judged=False,
            )
            for name in ("mhe-rti", "mhe")
            for mode in (STEP, OVERHEAD)
        ),
        *(
            Entry(
                name,
                mode,
                partial(ExportedStep, name=name, real=real, settings=settings),
                horizon=horizon,
                judged=judged,
            )
            for name, horizon, settings, judged in (
                ("ekf", FILTER_HORIZON, {}, True),
                ("mhe-rti", LIVE_HORIZON, LIVE, False),
            )
            for mode, real in ((EXPORTED, "double"), (EXPORTED_FLOAT, "float"))
        ),
    )


REUSE_HORIZONS = (LIVE_HORIZON, 100)
"""N of what keeps factors along a stream, and of its full passes."""

REUSE_CONTENDERS: tuple[Entry[Sample], ...] = tuple(
    Entry(
        "mhe-rti",
        mode,
        partial(
            LiveStep,
            name="mhe-rti",
            counted=mode,
            settings={"horizon": horizon, "reuse_threshold": threshold},
        ),
        horizon=horizon,
        judged=False,
    )
    for horizon in REUSE_HORIZONS
    for mode, threshold in ((STREAM_CALL, None), (FULL_STREAM_CALL, 0.0))
)
"""What steps along a stream as it does by default, and with full passes only."""


def stream_contenders(samples: int) -> tuple[Entry[SampleStream], ...]:
    """Return what takes a whole stream of some samples in one call."""
    build = {name: partial(Batch, name=name) for name in ("ekf", "mhe-rti", "mhe")}
    return (
        Entry("ekf", BATCH, build["ekf"], samples, FILTER_HORIZON),
        *(
            Entry(name, BATCH, build[name], samples, LIVE_HORIZON, judged=False)
            for name in ("mhe-rti", "mhe")
        ),
    )
