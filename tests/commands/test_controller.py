"""`--controller`: a control law of the user's own in the commands."""

import importlib
import re
from pathlib import Path

import pytest

from workbench.control.controller_file import load_controller
from workbench.gains.gains import load_gains

PAGE = Path(__file__).parents[2] / "docs" / "controllers.md"


@pytest.fixture
def mine(write):
    """Return the controller that docs/controllers.md shows."""
    text = PAGE.read_text(encoding="utf-8")
    return write("mine.py", re.search(r"```python mine.py\n(.*?)```", text, re.DOTALL)[1])


def test_its_module_is_found_by_name_as_machine_code_that_is_loaded_again_needs_it(mine):
    first = load_controller(mine)
    mine.write_text(first.text + "\n# edited\n", encoding="utf-8")
    for law in (first, load_controller(mine)):
        assert importlib.import_module(law.update.__module__).update is law.update


def test_its_parameters_are_listed(run, mine):
    rows = run("params", "--controller", mine, "--set", "d_tilt=25", "--json").json["parameters"]
    values = {row["name"]: row["value"] for row in rows}
    assert values["d_tilt"] == 25.0 and values["p_tilt"] == 150.0
    assert not {"kp_roll", "kd_roll"} & set(values)


def test_its_gains_are_saved_shown_compared_and_restored(run, refused, mine, tmp_path):
    own, file = ("--controller", mine), tmp_path / "g.yaml"
    assert run("gains", "save", file, *own, "--set", "d_tilt=25").code == 0
    assert run("gains", "save", file, *own, "--set", "d_tilt=30").code == 0
    assert load_gains_of(run, file, own) == 30.0
    rows = run("gains", "diff", file, "rule", *own, "--json").json["rows"]
    assert {row["name"]: (row["a"], row["b"]) for row in rows}["d_tilt"] == (30.0, 20.0)
    assert len(run("gains", "history", file, *own, "--json").json["states"]) == 2
    assert run("gains", "restore", file, "0", *own).code == 0
    assert load_gains_of(run, file, own) == 25.0
    for words in (("show", file), ("history", file), ("restore", file, "0")):
        assert "of the controller mine: name its file, as --controller" in refused("gains", *words)
    assert "let mine fly" in refused("gains", "show", file, "--controller", "pid")


def load_gains_of(run, file, own) -> float:
    """Return d_tilt, as `gains show` prints it."""
    shown = run("gains", "show", file, *own, "--json").json
    assert shown["controller"] == "mine"
    return next(row["value"] for row in shown["gains"] if row["name"] == "d_tilt")


def test_gains_of_a_shipped_controller_need_no_option(run, tmp_path):
    file = tmp_path / "g.yaml"
    assert run("gains", "save", file, "--controller", "pid").code == 0
    assert run("gains", "show", file, "--json").json["controller"] == "pid"
    assert load_gains(file).controller == "pid"


def test_a_scenarios_own_controller_runs_only_when_it_is_named(refused, mine, write, case):
    """A parameter that there is not tells that the scenario was read, without a flight."""
    scenario = write("s.yaml", "controller: mine.py\n")
    for words in (
        ("fly", scenario),
        ("serve", "--scenario", scenario),
        ("lidar-trial", "--scenario", scenario),
        ("frames", "--scenario", scenario, "--at-time", "1"),
    ):
        with case(words):
            assert f"as --controller {mine}" in refused(*words)
            said = refused(*words, "--controller", mine, "--set", "kp_roll=3")
            assert "unknown parameter 'kp_roll'" in said


def test_a_spec_names_one_and_regress_takes_it(refused, mine, write):
    spec = write(
        "s.workbench.yaml",
        "controller: mine.py\ncases:\n  - {name: up, axis: z, amplitude: 1, baseline: {v_z: {}}}\n",
    )
    assert f"as --controller {mine}" in refused("regress", spec)
    said = refused("regress", spec, "--controller", "pid", "--update")
    assert (
        f"{spec}:1: a baseline belongs to the spec as it is written, whose controller is mine.py"
        in said
    )


@pytest.mark.slow
def test_hover_prints_its_gains(run, mine, tmp_path):
    said = run("hover", "--controller", mine, "--output", tmp_path, "--set", "d_tilt=21")
    assert said.code == 0
    assert re.search(r"d_tilt +21 +1/s", said.out) and "kp_roll" not in said.out


@pytest.mark.slow
def test_replay_flies_it_again_and_tells_that_its_file_has_changed(run, refused, mine, tmp_path):
    log = tmp_path / "f.mcap"
    short = ("--duration", "0.5", "--no-plots", "--output", tmp_path)
    assert run("fly", "hover", "--controller", mine, "--log", log, *short).code == 0
    assert f"as --controller {mine}" in refused("replay", log)
    assert "equal: all" in run("replay", log, "--controller", mine).out
    text = mine.read_text(encoding="utf-8")
    mine.write_text(text.replace("+ GRAVITY, g)", "+ 0.999 * GRAVITY, g)"), encoding="utf-8")
    changed = run("replay", log, "--controller", mine)
    assert changed.code == 1 and "the likely reason: controller mine with SHA-256" in changed.out


def test_it_flies_in_real_time_while_its_file_is_watched(run, refused, mine, tmp_path):
    watch = ("fly", "hover", "--watch", "--duration", "0.5", "--output", tmp_path / "out")
    said = run(*watch, "--controller", mine)
    assert said.code == 0
    assert f"{mine} flies, drawn at http://" in said.err and "duration" in said.out
    assert "name its file, as --controller mine.py" in refused(*watch, "--controller", "pid")
    own = (*watch, "--controller", mine)
    assert "leave out --html" in refused(*own, "--html", tmp_path / "film.html")
    commands = tmp_path / "commands.csv"
    assert "--rotor-commands" in refused(*own, "--rotor-commands", commands)


def test_python_that_only_a_script_names_does_not_run(refused, mine, write):
    script = "{at: 0.2, controller: other.py}"
    write("other.py", "raise SystemExit('it ran')")
    flight = write("theirs.yaml", f"script: [{script}]\n")
    case = f"name: a, duration: 1, signal: v_x, limits: {{maximum: {{max: 1}}}}, script: [{script}]"
    spec = write("theirs.workbench.yaml", f"cases: [{{{case}}}]\n")
    for words in (("fly", flight), ("fly", flight, "--controller", mine), ("regress", spec)):
        assert "other.py is Python code that would run here" in refused(*words)
