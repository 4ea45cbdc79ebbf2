"""The page of performance follows from its figures, and other simulators are spoken with."""

import ast
import importlib
import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
BENCHMARKS, DOCS = ROOT / "benchmarks", ROOT / "docs"
MISSED = {
    *(
        f"1,024 compiled flights a second, relative to {other}"
        for other in ("crazyflow as it comes", "crazyflow on two devices", "RotorPy")
    ),
    *(
        f"{what} of a batch of 1,024 in equal processor time, relative to crazyflow {how}"
        for what in ("physics steps", "seconds flown")
        for how in ("as it comes", "on two devices")
    ),
    "physics steps a second of a batch of 1,024, relative to crazyflow on two devices",
    "time of `sweep` of 1,024, relative to loading Drake's plant",
    "99th percentile of the age of what eight watchers read, relative to a server that only "
    "copies the bytes",
}
"""Requirements that the recorded figures do not meet."""


@pytest.fixture
def load(monkeypatch):
    """Load modules of the benchmarks, which are no package."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    return importlib.import_module


@pytest.fixture(scope="module")
def results():
    return json.loads((DOCS / "performance.json").read_text(encoding="utf-8"))


def test_the_page_follows_from_the_figures(load, results):
    assert (DOCS / "performance.md").read_text(encoding="utf-8") == load("page").page(results)


def test_the_figures_miss_no_other_requirement(load, results):
    """One that was not measured is a LookupError."""
    figures = results["benchmarks"]
    assert {each.what for each in load("targets").TARGETS if not each.holds(figures)} == MISSED


def test_each_benchmark_can_be_run_alone(load, results):
    names = load("run").NAMES
    assert set(results["benchmarks"]) <= set(names)
    for name in names:
        tree = ast.parse((BENCHMARKS / f"{name}.py").read_text(encoding="utf-8"))
        functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert {"measure", "show"} <= functions, name


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.0, "0"),
        (0.01234, "0.0123"),
        (1.0, "1"),
        (1.001, "1.00"),
        (1024.0, "1,024"),
        (99.96, "100"),
        (28612.3, "28,600"),
        (-3.14159, "-3.14"),
        (0.00001234, "1.2e-05"),
        (float("nan"), "none"),
    ],
)
def test_three_digits_count(load, value, said):
    assert load("spread").number(value) == said


def test_a_spread_has_quartiles_and_of_few_turns_the_ends(load):
    spread = load("spread")
    assert spread.spread([3.0, 1.0]) == spread.Spread(2.0, 1.0, 3.0)
    assert spread.spread([1.0, 2.0, 3.0, 4.0, 5.0]) == spread.Spread(3.0, 1.5, 4.5)


def test_ratios_are_taken_turn_by_turn(load):
    spread = load("spread")
    # the machine was four times slower in the last turn: the ratio is not
    assert spread.ratios([2.0, 2.0, 8.0], [1.0, 1.0, 4.0]) == spread.Spread(2.0, 2.0, 2.0)


@pytest.mark.parametrize(
    ("at_least", "value", "holds"),
    [(True, 15.0, True), (True, 14.9, False), (False, 15.0, True), (False, 15.1, False)],
)
def test_a_target_is_held_by_the_median(load, at_least, value, holds):
    targets = load("targets")
    target = targets.Target("speed", 15.0, at_least, lambda figures: figures["speed"])
    assert target.holds({"speed": value}) is holds
    assert target.holds({"speed": {"median": value, "lower": 0.0, "upper": 99.0}}) is holds


def test_a_row_is_found_by_the_beginning_of_its_name(load):
    rows = [{"name": "RotorPy 3", "count": 1}, {"name": "RotorPy 3", "count": 64}]
    row = load("targets").row
    assert row({"sweep": rows}, "sweep", name="RotorPy", count=64) is rows[1]
    with pytest.raises(LookupError, match="crazyflow"):
        row({"sweep": rows}, "sweep", name="crazyflow")


def test_the_page_tells_what_was_not_measured(load):
    text = load("page").page({"machine": "", "versions": {}, "benchmarks": {}})
    assert "| the tuning screen's map, s | at most 0.2 | not measured |" in text


@pytest.mark.parametrize(
    ("median", "line"),
    [
        (0.3, "| the tuning screen's map, s | at most 0.2 | 0.300 (0.100 .. 0.400) † |"),
        (0.15, "- the tuning screen's map, s: 0.150 †"),
    ],
)
def test_a_figure_that_fails_is_in_the_table_and_one_that_holds_in_the_list(load, median, line):
    rows = [{"name": "32 x 32", "seconds": dict(median=median, lower=0.1, upper=0.4)}]
    results = {"machine": "", "versions": {}, "benchmarks": {"gain_map": rows}}
    page = load("page")
    assert line in (page.page(results) if median > 0.2 else page.met_requirements(results))


def test_what_is_met_is_printed_and_the_page_written_when_asked_for(
    load, results, tmp_path, monkeypatch, capsys
):
    page = load("page")
    monkeypatch.setattr(page, "DOCS", tmp_path)
    (tmp_path / "performance.json").write_text(json.dumps(results), encoding="utf-8")
    page.main([])
    count = len(capsys.readouterr().out.splitlines())
    written = (DOCS / "performance.md").read_text(encoding="utf-8")
    assert f"The other {count} are met" in written
    assert [each.name for each in tmp_path.iterdir()] == ["performance.json"]
    page.main(["--write"])
    assert (tmp_path / "performance.md").read_text(encoding="utf-8") == written
    assert (tmp_path / "performance.png").is_file()


@pytest.fixture
def simulators(load, tmp_path, monkeypatch):
    """Let environments be this one, and their scripts be in a folder of the test's."""
    module = load("simulators")
    folder = tmp_path / "others"
    folder.mkdir()
    (folder / "serving.py").write_text((BENCHMARKS / "others" / "serving.py").read_text())
    monkeypatch.setattr(module, "HERE", tmp_path)
    monkeypatch.setattr(module, "KEPT", tmp_path)
    monkeypatch.setattr(module, "_environment", lambda name: sys.executable)
    return module


def test_another_simulator_answers_whatever_it_prints(simulators, tmp_path):
    (tmp_path / "others" / "with_noisy.py").write_text(
        "from serving import serve\n"
        "def double(number):\n"
        "    print('a greeting')\n"
        "    return {'seconds': 2 * number}\n"
        "serve({'double': double})\n"
    )
    with simulators.OtherSimulator("noisy") as simulator:
        assert simulator.ask("double", number=4.0) == {"seconds": 8.0}
        assert simulator.ask("double", number=5.0) == {"seconds": 10.0}
    assert "a greeting" in (tmp_path / "noisy.log").read_text()


def test_a_simulator_that_breaks_is_a_sentence(simulators, tmp_path):
    (tmp_path / "others" / "with_broken.py").write_text("import no_such_simulator\n")
    with (
        simulators.OtherSimulator("broken") as simulator,
        pytest.raises(simulators.NoSimulatorError, match="No module named 'no_such_simulator'"),
    ):
        simulator.ask("fly")


def test_a_simulator_on_no_index_says_where_to_put_it(load, tmp_path, monkeypatch):
    module = load("simulators")
    nowhere = BENCHMARKS.parent / "no_such_folder"
    monkeypatch.setitem(module.CHECKOUTS, "pybullet_drones", nowhere)
    with pytest.raises(module.NoSimulatorError, match="put a checkout into no_such_folder"):
        module.OtherSimulator("pybullet_drones")


def test_versions_are_the_pinned_ones(load):
    assert load("simulators").version("rotorpy", "rotorpy") == "3.0.0"
    assert load("simulators").version("crazyflow", "crazyflow") == "0.4.0"
