"""What the README and the pages list is what there is, and no page or link is missing."""

import re
from pathlib import Path

import workbench.controllers
import workbench.estimators
from workbench.common.resources import list_worlds, worlds_dir
from workbench.control.controller import COMMON_PARAMETERS
from workbench.control.controller_file import UPDATE_ARGUMENTS, load_controller
from workbench.control.guidance import KnownBody, MeasuredMotion
from workbench.control.installed_laws import SHIPPED_CONTROLLERS
from workbench.control.mode import FlightMode
from workbench.design.metrics import WISHED_METRICS
from workbench.design.tune.wish import SUBJECT_GROUPS, load_wishes, subjects_of
from workbench.gui.charts.chart_kind import SPECTRUM_CHART
from workbench.gui.visualization.layouts import read_layout
from workbench.link.drone_topics import drone_topics
from workbench.link.ros_messages.conversion import conversion
from workbench.link.signal import TopicOptions
from workbench.live.flight import LiveFlight
from workbench.logs.contents import ACTIONS_CHANNEL, STATE_CHANNEL
from workbench.plant.worlds.reading import read_world
from workbench.scenario.pilot_orders import PilotOrders

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
    """The package is not there: `pip install` of its name finds nothing, or somebody else's.

    With an extra pip adds to what is installed.
    """
    wrong = re.compile(r"pip install\s+[\"'`\s]*drake-drone-workbench(?! @|\[)")
    files = [README, *ROOT.glob("docs/*.md"), *ROOT.glob("workbench/**/*.py"), *ROOT.glob("*.md")]
    assert [path.name for path in files if wrong.search(path.read_text(encoding="utf-8"))] == []


def test_each_convention_names_a_test_that_there_is(case):
    """A name without a folder is in that of the one before it, or in `tests`."""
    tests = ROOT / "tests"
    rows = re.findall(r"^\| (?!convention|---).* \|$", page("conventions.md"), re.MULTILINE)
    assert len(rows) > 30
    for row in rows:
        convention, *_, other_side = (cell.strip() for cell in row.strip("|").split(" | "))
        with case(convention):
            folder = tests
            names = re.findall(r"`([\w/]+\.py)`", other_side)
            assert names
            for name in names:
                found = [it / name for it in (tests, folder) if (it / name).is_file()]
                assert found, name
                folder = found[0].parent


def test_the_layout_on_the_page_of_the_app_is_read(tmp_path):
    path = tmp_path / "vibration.layout.yaml"
    path.write_text(shown("app.md", path.name), encoding="utf-8")
    layout = read_layout(path)
    assert [chart.kind for chart in layout.charts] == [SPECTRUM_CHART, "time"]
    assert layout.signals[0].parsed.signals == ("v_x", "v_y")


def test_the_page_of_controllers_names_all_that_a_file_may_use():
    names = [name for name in vars(workbench.controllers) if re.match(r"[A-Za-z]", name)]
    left_out = (*SHIPPED_CONTROLLERS, "betaflight_sitl", "pd_rule", "Scalar", "Vector")
    names = [name for name in names if name not in left_out]
    names += [
        *MeasuredMotion._fields,
        *KnownBody._fields,
        *UPDATE_ARGUMENTS,
        *(row.name for row in COMMON_PARAMETERS),
    ]
    text = page("controllers.md")
    assert [name for name in names if not re.search(rf"[`.\[]{name}\b", text)] == []
    headings = re.findall(r"^### (\w+)$", text, re.MULTILINE)
    assert [name for name in headings if name in SHIPPED_CONTROLLERS] == [*SHIPPED_CONTROLLERS]


def test_the_table_for_own_estimators_names_what_a_file_may_import():
    rows = re.findall(r"^\| (`.*?) \|", table("estimation.md", "| name | value |"), re.MULTILINE)
    named = re.findall(r"`(\w+)", "".join(rows)) + ["crossed"]
    assert sorted(named) == sorted(name for name in vars(workbench.estimators) if name[0].isalpha())


def test_the_modes_are_numbered_as_written():
    text = page("files.md").replace("\n", " ")
    for mode in FlightMode:
        assert f"{mode.label} {mode.value}" in text


def test_the_orders_to_a_live_flight_are_those_there_are():
    rows = table("live.md", "| what | orders |")
    named = set(re.findall(r"`(\w+)(?:\([^`]*\))?`", rows)) - {"wait"}
    methods = {**vars(PilotOrders), **vars(LiveFlight)}
    there = {name for name, each in methods.items() if callable(each) and name[0] != "_"}
    assert named == there - {"do", "wait", "close", "latest", "streamed"}


def test_every_topic_of_a_log_stands_on_its_page_or_that_of_ros_2():
    scan = {"azimuths": [0.0, 0.1, 1], "elevations": [0.0, 0.0, 1]}
    outfit = TopicOptions(
        4,
        205,
        34,
        rates={"imu": 200, "gps": 10, "lidar": 10},
        rays=1,
        scan=scan,
        frames=[("world", "base_link")],
        joints=["arm"],
        contacts=["arm_link"],
        cables=["sling"],
    )
    channels = [each for topic in drone_topics(outfit) for each in conversion(topic).channels]
    text = (page("logs.md") + page("ros2.md")).replace("/msg/", "/")
    for channel in (*channels, STATE_CHANNEL, ACTIONS_CHANNEL):
        assert channel.topic.removeprefix("/dh_drone/") in text, channel
        assert channel.type.replace("/msg/", "/").removeprefix("dh_drone_msgs/") in text, channel


def test_all_that_can_be_wished_for_is_listed(tmp_path):
    text, law = page("tuning.md"), load_controller()
    names = [metric.name for metric in WISHED_METRICS] + list(SUBJECT_GROUPS)
    names += dict.fromkeys(each for metric in WISHED_METRICS for each in subjects_of(metric, law))
    missing = [name for name in names if f"`{name}`" not in text]
    alike = [f"{what}_{axis}" for what in ("velocity", "position") for axis in "yz"]
    points = ("position_{}_error", "velocity_{}_error", "acceleration_{}")
    assert missing == alike + [point.format(axis) for point in points for axis in "yz"]
    path = tmp_path / "wishes.yaml"
    path.write_text(shown("tuning.md", path.name), encoding="utf-8")
    assert len(load_wishes(path).wishes) == 3 and dict(load_wishes(path).steps)["yaw"] == 0.3


def test_pages_show_each_picture_of_the_app_that_is_taken_for_them():
    tool = (ROOT / "tools" / "app_pictures.py").read_text(encoding="utf-8")
    taken = re.findall(r'Shot\("([\w-]+\.png)"', tool)
    assert len(taken) >= 2
    taken += [path.name for path in (ROOT / "docs").glob("app-*.png")]
    text = "".join(path.read_text() for path in (README, *(ROOT / "docs").glob("*.md")))
    assert [name for name in taken if name not in text] == []


def test_the_worlds_on_the_page_are_there(tmp_path):
    named = {"empty", "room", "obstacle_field", "moving_obstacle"}
    assert named <= set(list_worlds())
    assert all(f"`{name}`" in page("worlds.md") for name in named)
    path = tmp_path / "yard.yaml"
    path.write_text(shown("worlds.md", path.name), encoding="utf-8")
    names = read_world(path, {"worlds": str(worlds_dir())}).names
    assert names == ("post", "crate::crate", "ball")
