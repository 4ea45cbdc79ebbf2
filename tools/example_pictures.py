"""Run the scripts of examples/ and write the pictures of docs/examples.md, as `make examples` does.

Names choose scripts: `python tools/example_pictures.py step_response own_law`.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = ROOT / "examples"
PICTURES = ROOT / "docs" / "examples"
WIDTH = 640
"""Of a picture [pixels]."""
COLOURS = 256
"""Of a picture: enough for lines and maps, and small. The octree keeps rare ones, as of a mark."""


def main() -> int:
    """Draw the pictures of the scripts that are named, else of all."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", help="scripts without .py; all if none is named")
    known = sorted(path.stem for path in SCRIPTS.glob("*.py"))
    names = parser.parse_args().names or known
    if unknown := set(names) - set(known):
        print(f"there is no example {min(unknown)}: name some of {', '.join(known)}")
        return 2
    PICTURES.mkdir(exist_ok=True)
    for name in names:
        out = PICTURES / f"{name}.png"
        draw(SCRIPTS / f"{name}.py", out)
        print(f"{out.relative_to(ROOT)}: {out.stat().st_size / 1000:.0f} kB", flush=True)
    return 0


def draw(script: Path, out: Path) -> None:
    """Run a script, and write its picture small."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "drawn.png"
        subprocess.run([sys.executable, str(script), str(drawn)], cwd=folder, check=True)
        with Image.open(drawn) as image:
            height = round(image.height * WIDTH / image.width)
            small = image.convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS)
            few = small.quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
            few.save(out, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
