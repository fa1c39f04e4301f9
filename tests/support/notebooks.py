"""Execution of the docs' notebooks; `make notebooks` updates them."""

import base64
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode
from patience import LONGEST_PROGRAM_S
from places import DOCS
from small_pictures import small

WIDTH_PIXELS = 1000
NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


def read(path: Path) -> NotebookNode:
    return nbformat.read(path, as_version=4)


def executed(notebook: NotebookNode, folder: Path) -> NotebookNode:
    """Execute a notebook from top to bottom in a new kernel in the folder."""
    options = {"kernel_name": "python3", "record_timing": False, "coalesce_streams": True}
    where = {"metadata": {"path": str(folder)}}
    return NotebookClient(notebook, timeout=LONGEST_PROGRAM_S, resources=where, **options).execute()


def shown(notebook: NotebookNode) -> dict[str, list[str]]:
    """Return each cell's outputs: texts verbatim, others by kind."""
    return {cell.id: [_text_or_kind(output) for output in cell.outputs] for cell in notebook.cells if "outputs" in cell}


def _text_or_kind(output: NotebookNode) -> str:
    if output.output_type == "stream":
        return f"{output.name}: {output.text}"
    kinds = sorted(kind for kind in output.data if kind != "text/plain")
    is_picture = any(kind.startswith("image/") for kind in kinds)
    return f"{kinds}" if is_picture else f"{kinds} {output.data.get('text/plain')}"


def write(path: Path) -> None:
    """The notebook anew, with what it shows and without what a machine or a run adds."""
    notebook = executed(read(path), path.parent)
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook.metadata = NotebookNode(kernelspec=kernel, language_info={"name": "python"})
    for output in (output for cell in notebook.cells for output in cell.get("outputs", ())):
        _make_small(output.get("data", {}))
    nbformat.write(notebook, path)


def _make_small(data: dict[str, str]) -> None:
    if "image/png" in data:
        data["image/png"] = base64.b64encode(small(base64.b64decode(data["image/png"]), WIDTH_PIXELS)).decode()


if __name__ == "__main__":
    for each in NOTEBOOKS:
        write(each)
