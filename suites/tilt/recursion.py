"""The recursion of `classical_baseline.fixed_weight` as a CasADi function.

To count its operations, and to time it as machine code: as the models' functions are.
"""

from __future__ import annotations

import time
from functools import cache

import casadi as ca
import numpy as np

from classical_baseline.fixed_weight import SMALLEST
from estimation.native import compiled
from models.arrays import Array
from suites.bound_call import BoundCall

BLOCK = 100
"""Samples in one timed call: its cost from Python is shared by as many."""


def recursion_function() -> ca.Function:
    """Return one step, (13)-(21) in the smooth form with the sign after the turn.

    ((R(n - 1), its rates) (5,), (acceleration, rates, T) (6,), w) → (R(n), rates) (5,)
    """
    R, before = ca.SX.sym("R", 3), ca.SX.sym("before", 2)
    acceleration, rates = ca.SX.sym("acceleration", 3), ca.SX.sym("rates", 2)
    T, weight = ca.SX.sym("T"), ca.SX.sym("weight")
    x, y, z = R[0], R[1], R[2]
    turned = (rates + before) / 2 * T
    phi, theta = ca.atan2(x, z) - turned[1], ca.atan2(y, z) + turned[0]
    side = ca.hypot(x, z) * ca.cos(phi) + ca.hypot(y, z) * ca.cos(theta) - z
    gx = ca.sin(phi) * ca.fabs(ca.cos(theta))
    gy = ca.fabs(ca.cos(phi)) * ca.sin(theta)
    gz = ca.copysign(ca.fabs(ca.cos(phi) * ca.cos(theta)), side)
    fused = _normalised(acceleration) + weight * _normalised(ca.vertcat(gx, gy, gz))
    return ca.Function(
        "fixed_weight",
        [ca.vertcat(R, before), ca.vertcat(acceleration, rates, T), weight],
        [ca.vertcat(_normalised(fused), rates)],
        ["state", "sample", "weight"],
        ["next"],
        {"cse": True},
    )


def raw_function() -> ca.Function:
    """Return the accelerometer's direction alone, (7)-(9)."""
    acceleration = ca.SX.sym("acceleration", 3)
    return ca.Function("raw", [acceleration], [_normalised(acceleration)])


def _normalised(vector: ca.SX) -> ca.SX:
    return vector / ca.fmax(ca.sqrt(ca.sumsqr(vector)), SMALLEST)


def run_compiled(
    weight: float, time_s: Array, acceleration: Array, rates: Array
) -> tuple[Array, Array]:
    """Return R (n, 3) as `run` does, and the times per sample of blocks (m,), s."""
    call, seconds = _recursion_block(), []
    call.arguments[2][:] = weight
    samples = np.column_stack([acceleration, rates, np.diff(time_s, prepend=time_s[0])])
    first = acceleration[0] / np.linalg.norm(acceleration[0])
    state, directions = np.concatenate([first, rates[0]]), [first[None]]
    for block in _blocks(samples[1:]):
        call.arguments[0][:], call.arguments[1][:] = state, _filled(block).ravel()
        seconds.append(_timed(call))
        states = call.results[0].reshape(BLOCK, -1)[: len(block)]
        directions.append(states[:, :3].copy())
        state = states[-1].copy()
    return np.vstack(directions), np.array(seconds)


def run_raw_compiled(acceleration: Array) -> tuple[Array, Array]:
    """Return the accelerometer's directions (n, 3), and times per sample of blocks (m,), s."""
    call, seconds, directions = _raw_block(), [], []
    for block in _blocks(acceleration):
        call.arguments[0][:] = _filled(block).ravel()
        seconds.append(_timed(call))
        directions.append(call.results[0].reshape(BLOCK, 3)[: len(block)].copy())
    return np.vstack(directions), np.array(seconds)


@cache
def _recursion_block() -> BoundCall:
    return BoundCall(compiled(recursion_function().mapaccum(BLOCK)))


@cache
def _raw_block() -> BoundCall:
    return BoundCall(compiled(raw_function().map(BLOCK)))


def _blocks(samples: Array) -> list[Array]:
    return [samples[start : start + BLOCK] for start in range(0, len(samples), BLOCK)]


def _filled(block: Array) -> Array:
    """Return a block of full length: its last sample again and again."""
    return np.vstack([block, np.repeat(block[-1:], BLOCK - len(block), axis=0)])


def _timed(call: BoundCall) -> float:
    begin = time.perf_counter()
    call.evaluate()
    return (time.perf_counter() - begin) / BLOCK
