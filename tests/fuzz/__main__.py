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
from pathlib import Path

import atheris

with atheris.instrument_imports(
    include=["models", "recordings", "benchmark", "pen_mhe", "tomllib", "json"]
):
    from tests.fuzz.mutators import mutated
    from tests.fuzz.seeds import seeds
    from tests.fuzz.targets import TARGETS, check, folder
    from tests.fuzz.words import TOKENS

MOST_GROWTH_MB = 500
"""Memory that reading may take, beyond what the process has before."""


OWN_CHANGES = 0.25
"""Part of the changes that are libFuzzer's."""
SHORTEST, FURTHER = 8192, 2
"""The longest input is that many bytes, or so many times the longest seed."""


def main() -> None:
    """Run what the command line asks for in a child: libFuzzer ends it, and clears nothing away."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--runs", type=int, default=100_000, help="inputs to try")
    parser.add_argument("--seconds", type=int, default=0, help="end after these, 0: never")
    parser.add_argument("--folder", type=Path, default=Path("build/fuzz"), help="corpus, findings")
    asked = parser.parse_args()
    folder()  # of this process, which removes it in the end
    if child := os.fork():
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        sys.exit(status)
    corpus = asked.folder / asked.target
    corpus.mkdir(parents=True, exist_ok=True)
    good = seeds(asked.target)
    for number, data in enumerate(good):
        (corpus / f"seed-{number}").write_bytes(data)
        check(asked.target, data)  # imports and caches are not what an input takes
    words = asked.folder / "words.txt"
    words.write_text("".join(f'"{_spelt(token)}"\n' for token in TOKENS if len(token) < 60))
    before_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    options = [
        f"-runs={asked.runs}",
        f"-max_total_time={asked.seconds}",
        f"-rss_limit_mb={before_mb + MOST_GROWTH_MB}",
        f"-max_len={max(SHORTEST, FURTHER * max(map(len, good)))}",
        f"-dict={words}",
        "-timeout=10",
        "-print_final_stats=1",
        f"-artifact_prefix={asked.folder}/{asked.target}-",
        str(corpus),
    ]
    atheris.Setup(
        [sys.argv[0], *options],
        lambda data: check(asked.target, bytes(data)),
        custom_mutator=_mutated,
    )
    atheris.Fuzz()


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
