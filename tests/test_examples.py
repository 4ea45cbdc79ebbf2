"""Each script of examples/ runs in an empty folder, prints numbers and draws a picture."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from PIL import Image

FOLDER = Path(__file__).parent.parent / "examples"
PICTURES = FOLDER.parent / "docs" / "examples"
LONGEST = 60
"""Lines of a script."""
SLOW = {  # more than 3 s, in real time, or compiled on a new machine
    "compare_gains",
    "estimate_and_truth",
    "gain_heat_map",
    "landing_gear",
    "monte_carlo",
    "network_client",
    "own_law",
    "predict_flight",
    "take_crate",
    "tune_to_wishes",
    "wind_rejection",
}
SCRIPTS = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.stem in SLOW else [])
    for path in sorted(FOLDER.glob("*.py"))
]


NAMED = {"poles_over_gain": "mine.png"}
"""Pictures of scripts that are called with a name for it."""
WITH_PROCESSES = {"monte_carlo", "network_client", "own_law", "tune_to_wishes"}
"""Scripts that start processes, which import the script by its path."""


@pytest.mark.parametrize("script", SCRIPTS)
def test_a_script_prints_numbers_and_draws(tmp_path, script, monkeypatch, capsys):
    monkeypatch.delenv("WORKBENCH_FLY_ON")
    monkeypatch.chdir(tmp_path)
    words = [str(script), *([NAMED[script.stem]] if script.stem in NAMED else [])]
    if script.stem in WITH_PROCESSES:
        printed = printed_by_a_process(words)
    else:
        monkeypatch.setattr(sys, "argv", words)
        with plt.rc_context():
            runpy.run_path(str(script), run_name="__main__")
            plt.close("all")
        printed = capsys.readouterr().out
    assert len(re.findall(r"\d+(?:\.\d+)?", printed)) >= 2
    (picture,) = tmp_path.iterdir()
    assert picture.name == NAMED.get(script.stem, f"{script.stem}.png")
    with Image.open(picture) as image:
        grey = image.convert("L")
        dark = sum(grey.histogram()[:200]) / (grey.width * grey.height)
    assert grey.width >= 500
    assert 0.005 < dark < 0.9


def test_scripts_are_short_and_say_how_they_are_called():
    for path in FOLDER.glob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= LONGEST, path.name
        assert f"\n    python {path.name} [OUTPUT.png]\n" in text, path.name
        assert f'else "{path.stem}.png")' in text, path.name


def test_the_slow_ones_are_there():
    assert {path.stem for path in FOLDER.glob("*.py")} >= SLOW


def test_the_gallery_has_a_small_picture_of_each_script():
    page = (PICTURES.parent / "examples.md").read_text(encoding="utf-8")
    scripts = {path.stem for path in FOLDER.glob("*.py")}
    assert {path.stem for path in PICTURES.iterdir()} == scripts
    for name in scripts:
        picture = PICTURES / f"{name}.png"
        assert f"](../examples/{name}.py)" in page
        assert f"](examples/{name}.png)" in page
        assert picture.stat().st_size < 60_000
        with Image.open(picture) as image:
            assert image.width == 640


def printed_by_a_process(words: list[str]) -> str:
    """Run a script as a user does, and return what it prints."""
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout
