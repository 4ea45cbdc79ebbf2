"""Run the notebooks and store in them what they show, as `make notebooks` does.

Cells run in one namespace from top to bottom, as "Restart Kernel and Run All Cells" of Jupyter
has it, but without Jupyter: a cell shows what it prints, the value of its last line, and its
figures. Pictures are stored small, so that a changed notebook stays a small change.
"""

import argparse
import ast
import base64
import io
import json
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from PIL import Image

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
DPI = 72
"""Of pictures; Jupyter's own."""
COLOURS = 256
"""Of a picture: enough for lines and maps, at a third of the size."""


def main() -> None:
    """Renew the outputs of the notebooks that are named, else of all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("notebooks", nargs="*", type=Path, help="files; all if none is named")
    paths = parser.parse_args().notebooks or sorted(FOLDER.glob("*.ipynb"))
    for number, path in enumerate(paths, start=1):
        print(f"{number} of {len(paths)}: {path.name} ...", flush=True)
        text = json.dumps(run(path), indent=1, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")


def run(path: Path) -> dict[str, Any]:
    """Return a notebook with the outputs of a run; what a cell raises is not caught."""
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    names: dict[str, Any] = {"__name__": "__main__"}
    with matplotlib.rc_context():
        for number, cell in enumerate(cells, start=1):
            where = f"{path.name}, cell {number}"
            cell["outputs"] = _outputs("".join(cell["source"]), names, where, number)
            cell["execution_count"] = number
    return notebook


def _outputs(source: str, names: dict[str, Any], where: str, number: int) -> list[dict[str, Any]]:
    """Return what a cell shows."""
    body = ast.parse(source).body
    last = body.pop() if isinstance(body[-1], ast.Expr) and source.rstrip()[-1] != ";" else None
    said, value = io.StringIO(), None
    with redirect_stdout(said):
        exec(compile(ast.Module(body, []), where, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    outputs: list[dict[str, Any]] = []
    if said.getvalue():
        text = said.getvalue().splitlines(keepends=True)
        outputs.append({"name": "stdout", "output_type": "stream", "text": text})
    if value is not None:
        result = {"execution_count": number, "output_type": "execute_result"}
        outputs.append({"data": _data(value), "metadata": {}, **result})
    for figure in plt.get_fignums():
        data = _data(plt.figure(figure))
        outputs.append({"data": data, "metadata": {}, "output_type": "display_data"})
    plt.close("all")
    return outputs


def _data(value: Any) -> dict[str, Any]:
    """Return a value as text, and a figure as a picture, too."""
    data: dict[str, Any] = {"text/plain": repr(value).splitlines(keepends=True)}
    if isinstance(value, Figure):
        full, small = io.BytesIO(), io.BytesIO()
        value.savefig(full, format="png", dpi=DPI, bbox_inches="tight")
        with Image.open(full) as image:
            image.convert("RGB").quantize(COLOURS).save(small, format="png", optimize=True)
        data["image/png"] = base64.b64encode(small.getvalue()).decode()
    return data


if __name__ == "__main__":
    main()
