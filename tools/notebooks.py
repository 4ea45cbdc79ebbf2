"""Run the notebooks and store in them what they show, as `make notebooks` does.

nbclient runs them in a kernel, as "Restart Kernel and Run All Cells" of Jupyter does. Pictures are
stored with few colours, so that a changed notebook stays a small change.
"""

import argparse
import base64
import io
import os
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
COLOURS = 256
"""Of a picture: enough for lines and maps, at a third of the size."""
LONGEST_CELL = 1200
"""Time limit of a cell [s]."""


def main() -> None:
    """Renew the outputs of the notebooks that are named, else of all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", type=Path, help="files; all if none is named")
    paths = parser.parse_args().notebooks or sorted(FOLDER.glob("*.ipynb"))
    for number, path in enumerate(paths, start=1):
        print(f"{number} of {len(paths)}: {path.name} ...", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            nbformat.write(run(path, Path(folder)), path)


def run(path: Path, folder: Path) -> nbformat.NotebookNode:
    """Return a notebook with the outputs of a run in a folder.

    Raises:
        CellExecutionError: if a cell raises an error.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        timeout=LONGEST_CELL,
        kernel_name="python3",
        record_timing=False,
        coalesce_streams=True,
        resources={"metadata": {"path": str(folder)}},
    )
    client.execute()
    notebook.metadata = {
        "kernelspec": notebook.metadata["kernelspec"],
        "language_info": {"name": "python"},
    }
    for cell in notebook.cells:
        if "outputs" in cell:  # progress, as of a first compilation, is not of the lecture
            cell.outputs = [each for each in cell.outputs if each.get("name") != "stderr"]
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", ()):
                output["data"]["image/png"] = _small(output["data"]["image/png"])
    return notebook


def _small(picture: str) -> str:
    """Return a picture with few colours; both are PNG in base 64."""
    small = io.BytesIO()
    with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
        image.convert("RGB").quantize(COLOURS).save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


if __name__ == "__main__":
    main()
