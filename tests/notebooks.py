"""Execute the tutorial notebooks and keep what they show: `python -m tests.notebooks`.

They are stored with their outputs, which is what a visitor of a code-hosting page sees; the suite executes them again
and compares.  What differs from run to run is left out: when cells ran, how often.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "sims" / "notebooks"
PATIENCE = 300  # seconds a cell, where all passes must be compiled


def paths() -> list[Path]:
    """The notebooks that there are."""
    return sorted(FOLDER.glob("*.ipynb"))


def executed(notebook: NotebookNode, *more: str) -> NotebookNode:
    """A copy with the outputs of a new kernel, and further cells of this code at its end.

    Raises nbclient's CellExecutionError where a cell does.
    """
    copy = nbformat.from_dict(notebook)
    for cell in copy.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    copy.cells += [nbformat.v4.new_code_cell(code) for code in more]
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    client = NotebookClient(
        copy, timeout=PATIENCE, record_timing=False, coalesce_streams=True, kernel_name="python3"
    )
    client.create_kernel_manager()
    client.execute(env=os.environ | {"PYTHONPATH": path, "MPLBACKEND": "agg"})
    return copy


def text_of(cell: NotebookNode) -> str:
    """What a cell printed and showed as text, pictures left out."""
    streams = [out.text for out in cell.outputs if out.output_type == "stream" and out.name == "stdout"]
    data = [out.data for out in cell.outputs if "data" in out]
    shown = [each.get("text/plain", "") for each in data if "image/png" not in each]
    return "".join(streams) + "\n".join(shown)


def main() -> None:
    for path in paths():
        start = time.perf_counter()
        done = executed(nbformat.read(path, as_version=4))
        nbformat.write(done, path)
        print(
            f"{path.relative_to(ROOT)}: {time.perf_counter() - start:.1f} s, {path.stat().st_size / 1e3:.0f} kB"
        )


if __name__ == "__main__":
    sys.exit(main())
