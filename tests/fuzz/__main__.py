"""Coverage-guided fuzzing of one reader: ``python -m tests.fuzz csv --runs 100000``.

Needs atheris, `pip install .[fuzz]`. An input that makes a finding is kept, and stays in the
corpus of the repository once it is mended: `tests.fuzz.test_fuzz` reads it from then on.
"""

from __future__ import annotations

import argparse
import os
import random
import resource
import sys
import time
from multiprocessing import RawArray
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["models", "recordings", "benchmark", "pen_mhe"]):
    from tests.fuzz.mutators import mutated
    from tests.fuzz.seeds import CORPUS, seeds
    from tests.fuzz.targets import TARGETS, check, folder
    from tests.fuzz.words import TOKENS

MOST_GROWTH_MB = 500
"""Memory that reading may take, beyond what the process has before."""


OWN_CHANGES = 0.25
"""Part of the changes that are libFuzzer's."""
FURTHER = 1024
"""Bytes that the longest input has more than the longest good file: long ones take long, and say
what short ones say."""
INPUTS, SLOWEST_S, ALL_S, PEAK_MB = range(4)
"""What a child counts, places in an array that its parent reads."""


def main() -> None:
    """Run what the command line asks for in a child: libFuzzer ends it, and clears nothing away."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--runs", type=int, default=100_000, help="inputs to try")
    parser.add_argument("--seconds", type=int, default=0, help="end after these, 0: never")
    parser.add_argument("--folder", type=Path, default=Path("build/fuzz"), help="corpus, findings")
    asked = parser.parse_args()
    folder()  # of this process, which removes it in the end
    counts = RawArray("d", 4)
    if child := os.fork():
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        print(
            f"{asked.target}: {counts[INPUTS]:.0f} inputs in {counts[ALL_S]:.0f} s of a processor, "
            f"the slowest {counts[SLOWEST_S]:.3f} s, memory {counts[PEAK_MB]:.0f} MB at most"
        )
        sys.exit(status)
    corpus = asked.folder / asked.target
    corpus.mkdir(parents=True, exist_ok=True)
    good = seeds(asked.target)
    for number, data in enumerate(good):
        (corpus / f"seed-{number}").write_bytes(data)
        check(asked.target, data)  # imports and caches are not what an input takes
    words = asked.folder / "words.txt"
    words.write_text("".join(f'"{_spelt(token)}"\n' for token in TOKENS if len(token) < 60))
    before_mb = _peak_mb()
    found = {path.read_bytes() for path in (CORPUS / asked.target).glob("*")}
    longest = max(len(data) for data in good if data not in found)

    def read(data: bytes) -> None:
        start = time.process_time()
        check(asked.target, bytes(data))
        counts[INPUTS] += 1
        counts[SLOWEST_S] = max(counts[SLOWEST_S], time.process_time() - start)
        counts[ALL_S], counts[PEAK_MB] = time.process_time() - began, _peak_mb()

    began = time.process_time()
    options = [
        f"-runs={asked.runs}",
        f"-max_total_time={asked.seconds}",
        f"-rss_limit_mb={before_mb + MOST_GROWTH_MB}",
        f"-max_len={longest + FURTHER}",
        f"-dict={words}",
        "-timeout=10",
        "-print_final_stats=1",
        f"-artifact_prefix={asked.folder}/{asked.target}-",
        str(corpus),
    ]
    atheris.Setup(
        [sys.argv[0], *options],
        read,
        custom_mutator=_mutated,
    )
    atheris.Fuzz()


def _peak_mb() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024


def _mutated(data: bytes, longest: int, seed: int) -> bytes:
    """Return a change that knows what it changes, or one of libFuzzer's own."""
    draw = random.Random(seed)
    if draw.random() < OWN_CHANGES:
        return bytes(atheris.Mutate(data, longest))
    return mutated(data, draw)[:longest]


def _spelt(token: bytes) -> str:
    """Return bytes as libFuzzer reads them in a list of words."""
    return "".join(f"\\x{byte:02x}" for byte in token)


if __name__ == "__main__":
    main()
