"""All our C under ASan and UBSan: ``python -m tests.sanitize``; a part of it with ``--quick``."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from tests.sanitize import example, exports, loops

FILES, FEW = 1000, 30
"""Changed files for the example program, and in the quick part."""


def main() -> None:
    """Run exports as programs, then tests with watched loops; end with 1 where one fails."""
    parser = argparse.ArgumentParser(prog="python -m tests.sanitize")
    parser.add_argument("--quick", action="store_true", help="what CI runs")
    parser.add_argument(
        "--folder", type=Path, default=Path("build/sanitize"), help="for compiled C"
    )
    asked = parser.parse_args()
    failed = False
    for name in exports.QUICK if asked.quick else exports.EXPORTS:
        watched = exports.EXPORTS[name]
        with tempfile.TemporaryDirectory() as scratch:
            told = exports.run(watched, exports.export_of(watched), Path(scratch))
        print(f"{name}: {told.stdout.strip() or told.stderr.strip()}", flush=True)
        failed = failed or told.returncode != 0
    with tempfile.TemporaryDirectory() as scratch:
        wrong = example.run(Path(scratch), FEW if asked.quick else FILES)
    print(f"example program: {wrong or 'every file read or refused in a line'}", flush=True)
    failed = failed or bool(wrong)
    tests = loops.QUICK if asked.quick else loops.ALL
    failed = bool(loops.run(asked.folder.resolve(), tests)) or failed
    sys.exit(failed)


if __name__ == "__main__":
    main()
