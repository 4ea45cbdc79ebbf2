"""`workbench compare`."""

import pytest

from workbench.design.comparison import COMPARISON_PARTS, COMPARISON_ROWS
from workbench.design.judge.margins import all_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Scenario

LIFTS = """
from workbench.controllers import GRAVITY

PARAMETERS = []


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    return (vehicle.mass * GRAVITY, 0.0, 0.0, 0.0), ()
"""
PNG = b"\x89PNG"


def test_margins_of_two_are_a_table_and_a_page(run, out):
    page = out / "compare.html"
    said = run("compare", "pd", "pid", "--parts", "margins", "--output", out, "--html", page)
    assert said.code == 0, said.err
    lines = said.out.splitlines()
    assert lines[0] == "dh_drone, each controller with its gains for it, or of its file"
    assert lines[2].split() == ["unit", "pd", "pid"]
    rows = {line.split()[0]: line.split() for line in lines[3:6]}
    assert list(rows) == [row.name for row in COMPARISON_ROWS if row.part == "margins"]
    least = min(m.disk_margin for m in all_margins(LinearStudy().sampled(), ["roll_acceleration"]))
    assert float(rows["own_disk_margin"][1]) == pytest.approx(least, abs=0.005)
    assert "pd, own_disk_margin: " in said.out
    assert (out / "compare.png").read_bytes()[:4] == PNG
    text = page.read_text()
    assert "<svg" in text
    assert "own_disk_margin" in text
    assert '<th></th><th>unit</th><th class="number">pd</th><th class="number">pid</th>' in text
    assert text.count('<td class="note">') == len(rows)  # what each number is
    assert '<body class="wide">' in text


def test_gain_files_are_columns(run, refused, out, tmp_path, write):
    """Each with the margins that its gains have; of an own law, with its file."""
    law = write("lifts.py", LIFTS)
    write("lifted.yaml", "controller: lifts\ngains: {}\n")
    soft = write("soft.yaml", "gains: {kp_roll: 120}\n")
    hard = write("hard.yaml", "gains: {kp_roll: 240}\n")
    options = ("--parts", "margins", "--no-plots", "--output", out, "--json")
    said = run("compare", "pd", soft, hard, f"{law}={tmp_path / 'lifted.yaml'}", *options)
    assert said.code == 0, said.err
    columns = {each["name"]: each["numbers"] for each in said.json["controllers"]}
    assert list(columns) == ["pd", "soft", "hard", "lifted"]
    for name, path in (("soft", soft), ("hard", hard)):
        scenario = Scenario()
        scenario.vehicle.gains = str(path)
        sampled = LinearStudy(scenario).sampled()
        expected = min(m.disk_margin for m in all_margins(sampled, ["roll_acceleration"]))
        assert columns[name]["own_disk_margin"] <= expected + 1e-9
    assert len({each["input_disk_margin"] for each in columns.values()}) == 4
    assert "name its file, too, as lifts.py=lifted.yaml" in refused(
        "compare", tmp_path / "lifted.yaml"
    )
    assert "two controllers are called soft" in refused("compare", soft, f"pd={soft}")
    assert "the gains are of the controller pd" in refused("compare", f"lqi={soft}")


@pytest.mark.slow
def test_what_a_law_has_not_is_a_dash_and_a_reason(run, out):
    said = run("compare", "pd", "--parts", "path", "--no-plots", "--output", out, "--json")
    assert said.code == 0, said.err
    (found,) = said.json["controllers"]
    assert found["numbers"]["path"] is None
    assert "does not use the path's acceleration" in found["remarks"]["path"]
    assert 0.05 < found["numbers"]["path_without"] < 2.0
    assert said.json["vehicle"] == "dh_drone"
    assert said.json["files"] == []


SEARCHED = {"pd": {"kp_yaw_rate"}, "lqi": {"q_yaw_integral", "q_yaw_rate"}}
"""Gains that the yaw rate hangs on."""


@pytest.mark.slow
@pytest.mark.parametrize("laws", [["pd", "lqi"]])
def test_each_is_tuned_for_the_same_wishes_first(run, out, write, laws):
    """The numbers are those of a flight with the gains that are told; a step meets the wish."""
    wish = write("wish.yaml", "wishes: [yaw.rise_time <= 0.35 s]\ndefaults: false\n")
    options = ("--parts", "steps", "--no-plots", "--output", out, "--json", "--tune", wish)
    said = run("compare", *laws, *options)
    assert said.code == 0, said.err
    assert [row["name"] for row in said.json["rows"]][0] == "unmet_wishes"
    assert [each["name"] for each in said.json["controllers"]] == laws
    for each in said.json["controllers"]:
        assert set(each["gains"]) == SEARCHED[each["name"]]
        assert each["numbers"]["unmet_wishes"] == 0.0
        scenario = Scenario(controller=each["name"])
        flown = fly_step("yaw", 0.2, scenario=scenario, settings=each["gains"])
        assert each["numbers"]["rise_time_yaw"] == flown.metrics.rise_time <= 0.35
    refused = run("compare", "pd", "--parts", "steps", "--tune", "yaw.rise_tim<=1")
    assert refused.code == 2
    assert "did you mean 'rise_time'" in refused.err


def test_a_law_that_states_no_loops_has_none_of_its_own(run, out, write):
    law = write("lifts.py", LIFTS)
    said = run("compare", law, "--parts", "margins", "--no-plots", "--output", out)
    assert said.code == 0, said.err
    (row,) = [line for line in said.out.splitlines() if line.startswith("own_disk_margin")]
    assert row.split()[1] == "-"
    assert "lifts, own_disk_margin: lifts states no LOOPS" in said.out


def test_bad_input_is_a_sentence_and_leaves_nothing(refused, case, out, write):
    for options, word in (
        (["pdd"], "did you mean 'pd'"),
        (["pd", "pd"], "two controllers are called pd"),
        (["pd", "--parts", "stepps"], "did you mean 'steps'"),
        (["pd", "--model", "dh_dron"], "dh_dron"),
        (["pd", "--scenario", "nowhere"], "nowhere"),
        ([write("my_law.py", "PARAMETERS = []\n")], "has no update"),
        ([], "NAME|FILE"),
    ):
        with case(options, word):
            assert word in refused("compare", "--output", out, *options)
            assert not out.parent.exists()


@pytest.mark.slow
def test_all_shipped_ones_have_all_numbers_or_say_why(run, out):
    names = ["pd", "pid", "geometric"]
    said = run("compare", *names, "--output", out, "--json")
    assert said.code == 0, said.err
    found = {each["name"]: each for each in said.json["controllers"]}
    assert list(found) == names
    assert {row["part"] for row in said.json["rows"]} == set(COMPARISON_PARTS)
    for name, each in found.items():
        for row in COMPARISON_ROWS:
            value = each["numbers"][row.name]
            assert value is not None or each["remarks"][row.name], (name, row.name)
    numbers = {name: each["numbers"] for name, each in found.items()}
    assert numbers["geometric"]["path"] < 0.05 < numbers["geometric"]["path_without"]
    assert numbers["pid"]["wind_error"] < 1e-3 < numbers["pd"]["wind_error"]
    assert numbers["pd"]["lost"] == 0.0
    assert (out / "compare.png").read_bytes()[:4] == PNG
