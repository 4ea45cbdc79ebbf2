"""What the README and the pages list is what there is, and no page or link is missing."""

import re
from pathlib import Path

import workbench.controllers
import workbench.estimators
from workbench.commands.predict import EFFECTS
from workbench.common.resources import list_worlds, worlds_dir
from workbench.control.controller import ARGUMENTS, COMMON, SHIPPED, load_controller
from workbench.control.flight_law import Body
from workbench.control.guidance import Measured
from workbench.control.mode import FlightMode
from workbench.design.metrics import WISHED
from workbench.design.predict.past import Effects
from workbench.design.predict.prediction import METHODS
from workbench.design.tune.wish import GROUPS, load_wishes, subjects_of
from workbench.estimation.settings import ComplementarySettings, EkfSettings
from workbench.gains.autopilots.table import load_table
from workbench.gateways.ros_messages.conversion import conversion
from workbench.gui.visualization.layouts import SPECTRUM, read_layout
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.live.flight import LiveFlight
from workbench.logs.contents import ACTIONS, STATE
from workbench.logs.readers.units import find_unit
from workbench.logs.step_response import LOOPS
from workbench.plant.data_sheet import DataSheet, Propeller, figures
from workbench.plant.worlds.reading import read_world

ROOT = Path(__file__).parents[2]
README, INDEX = ROOT / "README.md", ROOT / "docs" / "index.md"
LONGEST = 115
"""Lines of the README: two screens."""


def page(name: str) -> str:
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def shown(name: str, file: str) -> str:
    return re.search(rf"```\w+ {re.escape(file)}\n(.*?)```", page(name), re.DOTALL)[1]


def table(name: str, head: str) -> str:
    return re.search(rf"^{re.escape(head)}\n.*?\n\n", page(name), re.DOTALL | re.MULTILINE)[0]


def test_the_readme_is_two_screens_long():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_every_page_is_in_the_index_and_every_link_leads_somewhere():
    index = INDEX.read_text(encoding="utf-8")
    pages = sorted((ROOT / "docs").glob("*.md"))
    assert [path.name for path in pages if path != INDEX and f"({path.name})" not in index] == []
    pages += [README, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    broken = [
        f"{path.name}: {target}"
        for path in pages
        for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", path.read_text(encoding="utf-8"))
        if "://" not in target and not (path.parent / target).exists()
    ]
    assert broken == []


def test_nothing_says_to_install_from_the_index():
    """The package is not there: `pip install` of its name finds nothing, or somebody else's."""
    wrong = re.compile(r"pip install\s+[\"'`\s]*drake-drone-workbench(?! @)")
    files = [README, *ROOT.glob("docs/*.md"), *ROOT.glob("workbench/**/*.py"), *ROOT.glob("*.md")]
    assert [path.name for path in files if wrong.search(path.read_text(encoding="utf-8"))] == []


def test_the_layout_on_the_page_of_the_app_is_read(tmp_path):
    path = tmp_path / "vibration.layout.yaml"
    path.write_text(shown("app.md", path.name), encoding="utf-8")
    layout = read_layout(path)
    assert [chart.kind for chart in layout.charts] == [SPECTRUM, "time"]
    assert layout.signals[0].parsed.signals == ("v_x", "v_y")


def test_the_factors_between_versions_of_autopilots_are_those_of_the_table():
    rows = [each for name in ("ardupilot", "px4") for each in load_table(name).settings]
    factors = {(each.name, each.law): each.scale for each in rows}
    assert factors["PSC_ACCZ_P", "PSC_D_ACC_P"] == 0.1
    assert factors["PSC_ACCZ_IMAX", "PSC_D_ACC_IMAX"] == 0.001
    assert factors["PSC_VELZ_IMAX", "PSC_D_VEL_IMAX"] == 0.01
    assert factors["PSC_ACCZ_FF", "PSC_D_ACC_FF"] == 1.0
    assert factors["MPC_Z_VEL_P", "MPC_Z_VEL_P_ACC"] == 20.0
    for each in ("PSC_VELXY_", "PSC_POSZ_P", "ATC_SLEW_YAW", "ANGLE_MAX", "WPNAV_SPEED"):
        assert f"`{each}" in page("autopilot-gains.md")


def test_the_page_of_controllers_names_all_that_a_file_may_use():
    names = [name for name in vars(workbench.controllers) if re.match(r"[A-Za-z]", name)]
    left_out = (*SHIPPED, "betaflight_sitl", "pd_rule", "Scalar", "Vector")
    names = [name for name in names if name not in left_out]
    names += [*Measured._fields, *Body._fields, *ARGUMENTS, *(row.name for row in COMMON)]
    text = page("controllers.md")
    assert [name for name in names if not re.search(rf"[`.\[]{name}\b", text)] == []
    headings = re.findall(r"^### (\w+)$", text, re.MULTILINE)
    assert [name for name in headings if name in SHIPPED] == [*SHIPPED]


def test_the_table_for_own_estimators_names_what_a_file_may_import():
    rows = re.findall(r"^\| (`.*?) \|", table("estimation.md", "| name | value |"), re.MULTILINE)
    named = re.findall(r"`(\w+)", "".join(rows)) + ["crossed"]
    assert sorted(named) == sorted(name for name in vars(workbench.estimators) if name[0].isalpha())


def test_the_table_of_estimators_has_every_parameter():
    named = set(re.findall(r"`((?:ekf|complementary)_\w+)`", page("estimation.md")))
    assert named >= {*EkfSettings._fields, *ComplementarySettings._fields}


def test_the_modes_are_numbered_as_written():
    text = page("files.md").replace("\n", " ")
    for mode in FlightMode:
        assert f"{mode.label} {mode.value}" in text


def test_the_shares_on_the_page_are_those_of_the_estimates():
    sheet = DataSheet("drone", 1.0, 0.2, Propeller(0.2), max_thrust=5.0)
    said = " ".join(figure.source for figure in figures(sheet))
    text = page("first-drone.md").replace("10 % in the arms", "10 % of the mass")
    for share in ("35 % of the mass", "10 % of the mass", "0.033 s at 5.1 in"):
        assert share in said
        assert share in text


def test_the_orders_to_a_live_flight_are_those_there_are():
    rows = table("live.md", "| what | orders |")
    named = set(re.findall(r"`(\w+)(?:\([^`]*\))?`", rows)) - {"wait"}
    there = {name for name, each in vars(LiveFlight).items() if callable(each) and name[0] != "_"}
    assert named == there - {"wait", "close", "latest", "streamed"}


def test_every_topic_of_a_log_stands_on_the_page():
    scan = {"azimuths": [0.0, 0.1, 1], "elevations": [0.0, 0.0, 1]}
    outfit = Outfit(4, 205, 34, 200, 10, 10, 1, scan, [("world", "base_link")])
    channels = [each for topic in drone_topics(outfit) for each in conversion(topic).channels]
    text = page("logs.md")
    for channel in (*channels, STATE, ACTIONS):
        assert channel.topic.removeprefix("/dh_drone/") in text, channel
        assert channel.type.replace("/msg/", "/").removeprefix("dh_drone_msgs/") in text, channel


def test_the_page_of_real_flights_names_units_and_loops():
    text = page("logs-of-real-flights.md")
    units = re.search(r"and their products: (.*?)\. There are also (.*?), and `g`", text, re.DOTALL)
    for unit in [*re.findall(r"`(.*?)`", units[1]), *re.findall(r"\w+", units[2]), "g"]:
        find_unit("1" if unit == "and" else unit)
    assert all(f"`{name}`" in text for name in ("roll_rate", "roll", "v_x", "x") if name in LOOPS)


def test_the_page_of_prediction_names_every_method_and_every_effect():
    assert Effects._fields == EFFECTS
    for name in (*METHODS, *EFFECTS):
        assert name in page("prediction.md").lower(), name


def test_all_that_can_be_wished_for_is_listed(tmp_path):
    text, law = page("tuning.md"), load_controller()
    names = [metric.name for metric in WISHED] + list(GROUPS)
    names += dict.fromkeys(each for metric in WISHED for each in subjects_of(metric, law))
    missing = [name for name in names if f"`{name}`" not in text]
    alike = [f"{what}_{axis}" for what in ("velocity", "position") for axis in "yz"]
    points = ("position_{}_error", "velocity_{}_error", "acceleration_{}")
    assert missing == alike + [point.format(axis) for point in points for axis in "yz"]
    path = tmp_path / "wishes.yaml"
    path.write_text(shown("tuning.md", path.name), encoding="utf-8")
    assert len(load_wishes(path).wishes) == 3 and dict(load_wishes(path).steps)["yaw"] == 0.3


def test_the_worlds_on_the_page_are_there(tmp_path):
    named = {"empty", "room", "obstacle_field", "moving_obstacle"}
    assert named <= set(list_worlds())
    assert all(f"`{name}`" in page("worlds.md") for name in named)
    files = {"yard.yaml": ("post", "crate::crate", "ball"), "yard.sdf": ("wall::link",)}
    for file, obstacles in files.items():
        path = tmp_path / file
        path.write_text(shown("worlds.md", file), encoding="utf-8")
        assert read_world(path, {"worlds": str(worlds_dir())}).names == obstacles
