"""Run notebooks, and keep what comes out: python -m tests.executed_notebooks [NOTEBOOK…]

Their figures stand in their files, as the site shows them. Real recordings are in the folder that
PEN_MHE_DATA names.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import nbclient
import nbformat

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
NOTEBOOKS = tuple(sorted(FOLDER.glob("*.ipynb")))


def executed(path: Path) -> Any:
    """Return a notebook after all of its cells have run, in its own folder."""
    notebook = nbformat.read(path, as_version=4)
    described = dict(notebook.metadata)
    nbclient.NotebookClient(
        notebook,
        timeout=300,
        record_timing=False,
        resources={"metadata": {"path": str(path.parent)}},
    ).execute()
    notebook.metadata = nbformat.from_dict(described)
    return notebook


if __name__ == "__main__":
    for path in [Path(name) for name in sys.argv[1:]] or NOTEBOOKS:
        text = nbformat.writes(executed(path)).rstrip("\n")
        path.write_text(text, "utf-8")
        print(path.name)
