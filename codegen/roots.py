"""A loop with square roots in place of covariances, estimation/root_form.c.

In single precision P⁻ - W Wᵀ soon is no covariance any more; S Sᵀ always is one.
"""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np

from estimation.linearisation import TRANSITION
from estimation.loop import Loop
from models.arrays import Array
from models.state_space import StateSpaceModel


def root(covariance: Array) -> Array:
    """Return the lower triangular S (n, n) of a positive definite P = S Sᵀ."""
    return np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)


def in_roots(model: StateSpaceModel, loop: Loop, start: Array) -> tuple[Loop, Array]:
    """Return the loop and its first state with the roots of all tables ``…covariance``."""
    n_x, start = model.n_x, start.copy()
    fields = {
        name: _rooted(value, n_x) if name.endswith("covariance") else value
        for name, value in loop.fields.items()
    }
    for block in loop.memory.shapes:
        if block.endswith("covariance"):
            view = loop.memory.view(start, block)
            view[...] = _rooted(view, n_x)
    functions = [_without_covariance(f) if f.name() == TRANSITION else f for f in loop.functions]
    return dataclasses.replace(loop, fields=fields, functions=functions), start


def _without_covariance(transition: ca.Function) -> ca.Function:
    """Return (x̃, w̃, Δt) → (f, F, G): roots need no Q; see `estimation.linearisation`.

    Known inputs keep their place, behind D.
    """
    every = transition.sx_in()
    n = 3 if transition.n_in() == 4 else transition.n_in()
    given, inputs = every[:n], every[4:]
    results = transition.call([*every[:3], ca.SX.ones(transition.size_in(3)), *inputs])[:3]
    names = transition.name_in()[:n], transition.name_out()[:3]
    return ca.Function(transition.name(), given, results, *names, {"cse": True})


def _rooted(stored: Array, n_x: int) -> Array:
    kept = np.zeros_like(stored)
    kept[:n_x, :n_x] = root(stored[:n_x, :n_x])
    return kept
