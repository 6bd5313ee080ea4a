"""Random numbers by purpose: one stream for each, all from one seed.

A stream depends on the seed and on the name of its purpose, not on which other
streams exist or how much was drawn from them. So one more sensor changes
neither another sensor's noise nor the motion.
"""

from __future__ import annotations

import numpy as np

from models.arrays import is_whole
from models.errors import InputError

Seed = int | np.random.SeedSequence | np.random.Generator
"""An integer or a seed sequence is one set of streams; a generator gives a new set each time."""


def seed_sequence(seed: Seed) -> np.random.SeedSequence:
    """Return the root of all streams of a seed; takes one number from a generator.

    Raises
    ------
    InputError
        If it is none of them.
    """
    if isinstance(seed, np.random.Generator):
        return np.random.SeedSequence(int(seed.integers(2**63)))
    if isinstance(seed, np.random.SeedSequence):
        return seed
    if not (is_whole(seed) and seed >= 0):
        raise InputError(f"seed is {seed!r}, expected a whole number from 0")
    return np.random.SeedSequence(seed)


def stream(root: np.random.SeedSequence, purpose: str) -> np.random.Generator:
    """Return the generator of a purpose, the same one at every call.

    Parameters
    ----------
    root : see `seed_sequence`
    purpose : any text: ``noise of gyro``
    """
    key = (*root.spawn_key, *purpose.encode())
    return np.random.default_rng(np.random.SeedSequence(root.entropy, spawn_key=key))
