"""Files that are opened, dropped, or flown again."""

import pytest
from PyQt6.QtCore import QMimeData, QPointF, Qt, QUrl
from PyQt6.QtGui import QDropEvent

from workbench.common.resources import controllers_dir, find_scenario
from workbench.gui.opener import FileKind
from workbench.live.choice import Choice
from workbench.scenario.scenario import Scenario, SensorsConfig


@pytest.fixture
def flown(workspace, monkeypatch):
    """What the window wants to fly."""
    choices = []
    monkeypatch.setattr(
        type(workspace.flight), "what", property(lambda _: choices[-1] if choices else Choice())
    )

    def fly(choice, draw):
        choices.append(choice)

    monkeypatch.setattr(workspace.flight, "fly", fly)
    return choices


def drop(window, path):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(path))])
    event = QDropEvent(
        QPointF(10.0, 10.0),
        Qt.DropAction.CopyAction,
        mime,
        Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.NoModifier,
    )
    window.dropEvent(event)


def test_a_dropped_file_is_flown_for_what_it_is(opened, flown, tmp_path):
    window = opened()
    drone, world = tmp_path / "mine.sdf", tmp_path / "park.world"
    drone.write_text("<sdf/>")
    world.write_text("<sdf/>")
    drop(window, find_scenario("windy"))
    drop(window, world)
    drop(window, drone)
    windy = str(find_scenario("windy"))
    assert flown == [
        Choice(windy),
        Choice(windy, world=str(world)),
        Choice(windy, model=str(drone), world=str(world), sensors=("all",)),
    ]
    assert [kind for kind, _ in window.recent.files()] == [
        FileKind.MODEL,
        FileKind.WORLD,
        FileKind.SCENARIO,
    ]


def test_a_dropped_log_goes_to_the_charts(opened, tmp_path):
    window = opened(first="home")
    log = tmp_path / "flight.mcap"
    log.write_bytes(b"")
    drop(window, log)
    assert window.stack.name == "visualization"
    assert window.stack.current.heard[-1] == "log flight.mcap"


def test_a_controller_is_flown_if_it_can_be_read(opened, flown, told, tmp_path):
    window = opened()
    window.control.fly(Choice(gains="mine.yaml"))
    window.actions_by_name["controller_pid"].trigger()
    own, wrong = tmp_path / "own.py", tmp_path / "wrong.py"
    own.write_text((controllers_dir() / "pid.py").read_text())
    wrong.write_text("def update(measured):\n    return 0\n")
    drop(window, own)
    drop(window, wrong)
    assert flown[1:] == [Choice(controller="pid"), Choice(controller=str(own))]
    assert f"{wrong}:1: update takes (measured): let it take (measured, setpoint" in told[0].what


def test_a_world_that_is_opened_after_a_set_up_keeps_the_rest_of_it(opened, flown):
    window = opened()
    sensors = SensorsConfig(use=["imu"], rates={"gps": 5.0, "gps_2": 2.0}, latency={"gps": 0.2})
    window.control.fly(Scenario(duration=7.0, sensors=sensors))
    window.control.fly_world("room")
    window.control.fly_model("cf2x")
    assert (flown[1].duration, flown[1].world, flown[1].sensors.use) == (7.0, "room", ["imu"])
    assert (flown[2].world, flown[2].vehicle.model) == ("room", "cf2x")
    of_kinds = SensorsConfig(use=["all"], rates={"gps": 5.0}, latency={"gps": 0.2})
    assert flown[2].sensors == of_kinds


def test_what_cannot_be_opened_is_a_notice(opened, told, tmp_path):
    window = opened()
    letter = tmp_path / "letter.txt"
    letter.write_text("Dear Ada")
    drop(window, letter)
    assert "letter.txt cannot be opened" in told[0].what
    drop(window, tmp_path / "gone.mcap")
    assert "gone.mcap: no such file" in told[1].what


def test_recent_files_fly_again_from_the_menu(opened, flown):
    window = opened()
    window.opener.open(FileKind.SCENARIO, find_scenario("hover"))
    (action,) = window.recent_menu.actions()
    assert "hover.yaml" in action.text()
    action.trigger()
    assert flown == [Choice(str(find_scenario("hover")))] * 2
