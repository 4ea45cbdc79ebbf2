"""The start page: its cards, their pictures, and a drone from a data sheet."""

from pathlib import Path

import numpy as np
import pytest
from PyQt6 import sip
from PyQt6.QtCore import Qt

from workbench.commands.cli import main
from workbench.common.resources import find_model, find_scenario, list_models, list_scenarios
from workbench.gui.recent_files import FileKind
from workbench.gui.start import sketch_worker
from workbench.gui.start.data_sheet_dialog import DataSheetDialog
from workbench.gui.start.sketch import Sketch
from workbench.gui.start.sketch_worker import (
    commanded_path,
    log_sketch,
    sketch_of,
    sketch_or_fault,
)
from workbench.gui.start.sketches import Sketches
from workbench.gui.start.start_screen import NO_FLIGHTS_TEXT, StartScreen
from workbench.plant.formats.xacro import MissingArgumentsError
from workbench.scenario.scenario import Action, FigureEight, Scenario, ScenarioStart

LEFT = Qt.MouseButton.LeftButton
SHIPPED = list_models()


@pytest.fixture
def asked(monkeypatch):
    """Files whose pictures are asked for; no process draws them."""
    made = []
    monkeypatch.setattr(Sketches, "ask", lambda _, kind, path: made.append((kind, path)))
    return made


@pytest.fixture
def screen(workspace, qtbot, asked):
    made = StartScreen(workspace)
    qtbot.addWidget(made)
    made.resize(1190, 560)
    made.show()
    yield made
    made.close_screen()


def test_the_shipped_drone_and_all_scenarios_have_a_card(screen, asked):
    assert [card.text() for card in screen.drones.cards] == SHIPPED
    assert [card.name for card in screen.scenarios.cards] == list_scenarios()
    assert screen.flights.cards == [] and screen.flights.nothing.text() == NO_FLIGHTS_TEXT
    assert len(asked) == len(SHIPPED) + len(list_scenarios())


def test_a_card_opens_its_file_and_recent_files_come_first(screen, workspace, qtbot, tmp_path):
    wanted = []
    workspace.recent.wanted.connect(lambda kind, path: wanted.append((kind, path)))
    (network,) = [card for card in screen.scenarios.cards if card.name == "network"]
    qtbot.mouseClick(network, LEFT)
    assert wanted == [(FileKind.SCENARIO, find_scenario("network"))]
    drone, log = tmp_path / "racer.urdf.xacro", tmp_path / "flight.mcap"
    for kind, path in ((FileKind.MODEL, drone), (FileKind.LOG, log)):
        path.write_text("")
        workspace.recent.add(kind, str(path))
    cards = screen.drones.cards
    assert [card.name for card in cards] == ["racer", *SHIPPED]
    qtbot.waitUntil(lambda: len({(card.x(), card.y()) for card in cards}) == len(cards))
    assert all(card.parentWidget().rect().contains(card.geometry()) for card in cards)
    assert screen.flights.nothing.isHidden()
    qtbot.mouseClick(screen.flights.cards[0], LEFT)
    assert wanted[-1] == (FileKind.LOG, log)
    asks = []
    workspace.recent.choice_wanted.connect(asks.append)
    for button in (screen.open_scenario, screen.open_drone, screen.open_log):
        qtbot.mouseClick(button, LEFT)
    assert asks == [FileKind.SCENARIO, FileKind.MODEL, FileKind.LOG]


def test_a_picture_takes_the_place_of_the_sign(screen):
    card = screen.drones.cards[0]
    before = card.icon().pixmap(168, 96).toImage()
    sketch = Sketch(circles=((0.0, 0.0, 1.0),), said="1.9 kg, 4 rotors")
    screen.sketches.ready.emit(card.path, sketch)
    assert card.icon().pixmap(168, 96).toImage() != before
    assert card.accessibleDescription() == "1.9 kg, 4 rotors"


def test_a_file_that_cannot_be_read_is_marked_with_the_reason(screen, workspace, tmp_path):
    """Until it can; the mark is words in the picture, and the reason is in the tip."""
    path = tmp_path / "notes.yaml"
    path.write_text("colour: blue\n")
    workspace.recent.add(FileKind.SCENARIO, str(path))
    card = screen.scenarios.cards[0]
    fault = sketch_or_fault(FileKind.SCENARIO, path)
    assert "colour" in fault.fault and fault.points == []
    before = card.icon().pixmap(168, 96).toImage()
    screen.sketches.ready.emit(path, fault)
    assert card.icon().pixmap(168, 96).toImage() != before
    assert card.accessibleDescription().startswith("could not be read: ")
    assert fault.fault in card.toolTip() and str(path) in card.toolTip()
    path.write_text("title: mended\n")
    screen.sketches.ready.emit(path, sketch_or_fault(FileKind.SCENARIO, path))
    assert card.accessibleDescription() == "mended"
    assert not card._fault


def test_a_drone_that_needs_arguments_is_not_called_unreadable(monkeypatch, tmp_path):
    """The app asks for them when it opens the drone."""
    path = tmp_path / "asks.urdf.xacro"

    def needs(*_):
        raise MissingArgumentsError(str(path), ())

    monkeypatch.setattr(sketch_worker, "sketch_of", needs)
    with pytest.raises(MissingArgumentsError):
        sketch_or_fault(FileKind.MODEL, path)


def test_a_process_draws_the_pictures_and_ends(qtbot, tmp_path):
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text("colour: blue\n")
    sketches, found = Sketches(), {}
    sketches.ready.connect(lambda path, sketch: found.update({path: sketch}))
    sketches.ask(FileKind.MODEL, find_model("dh_drone"))
    sketches.ask(FileKind.MODEL, Path("/nowhere/else.urdf"))
    sketches.ask(FileKind.SCENARIO, wrong)
    sketches.ask(FileKind.SCENARIO, find_scenario("hover"))
    qtbot.waitUntil(lambda: len(found) == 3)
    qtbot.waitUntil(lambda: sketches._process is None)
    assert [path for path, sketch in found.items() if sketch.fault] == [wrong]
    sketches.close()


def test_a_drone_is_drawn_from_above_with_its_nose_up():
    """By hand: arms of 0.25 m at 45°, so rotors 0.354 m apart; drawn with 0.4 of that."""
    sketch = sketch_of(FileKind.MODEL, find_model("dh_drone"))
    assert len(sketch.circles) == 4
    for x, y, radius in sketch.circles:
        assert (abs(x), abs(y)) == pytest.approx((0.25 / 2**0.5,) * 2)
        assert radius == pytest.approx(0.4 * 0.25 * 2**0.5)
    assert sketch.said == "1.9 kg, 4 rotors"


@pytest.mark.parametrize(
    ("scenario", "path"),
    [
        (
            Scenario(
                start=ScenarioStart(position=[1.0, 0.0, 1.5]),
                script=[
                    Action(at=1.0, velocity=[2.0, 0.0, 0.0]),
                    Action(at=2.5, velocity=[0.0, 1.0, 0.0]),
                    Action(at=4.5, request="hold"),
                ],
                duration=9.0,
            ),
            [(1.0, 0.0), (1.0, 0.0), (4.0, 0.0), (4.0, 2.0), (4.0, 2.0)],
        ),
        (
            Scenario(script=[Action(at=1.0, go_to=[3.0, 4.0, 1.0])]),
            [(0.0, 0.0), (0.0, 0.0), (3.0, 4.0), (3.0, 4.0)],
        ),
    ],
)
def test_a_scenario_is_drawn_with_the_path_that_it_commands(scenario, path):
    assert np.allclose(commanded_path(scenario), path)


def test_a_figure_of_eight_has_its_length_and_width():
    eight = FigureEight(center=[1.0, 2.0, 1.5], length=4.0, width=2.0)
    low, high = (
        np.min(commanded_path(Scenario(figure_eight=eight)), 0),
        np.max(commanded_path(Scenario(figure_eight=eight)), 0),
    )
    assert np.allclose([low, high], [[-1.0, 1.0], [3.0, 3.0]], atol=0.01)


def test_a_log_is_drawn_by_its_flown_path(canned, tmp_path):
    """The flight goes 2 m/s along x from 1 s to 3 s."""
    from workbench.link.backplane import Sampled
    from workbench.logs.flight_log import FlightLog

    view, path = canned.views[0], tmp_path / "flight.mcap"
    log = FlightLog(path, view.topics, view.scenario, {}, dict(view.values), view.vehicle.name)
    for some in canned.published:
        for each in some:
            log.write(Sampled(each, (1.0,) + 12 * (0.0,)))
    log.close()
    sketch = log_sketch(path)
    x, y = np.transpose(sketch.path)
    end = canned.views[-1].snapshot.p_WB
    assert (x[-1], y[-1]) == pytest.approx(end[:2], abs=0.1)
    assert np.ptp(x) > 2.0 and "dh_drone" in sketch.said


@pytest.fixture
def dialog(qtbot, tmp_path):
    made = DataSheetDialog(tmp_path)
    made.show()
    yield made
    if not sip.isdeleted(made):  # it is closed where it has made a drone
        made.close()


def fill(dialog, qtbot, **texts):
    for name, text in texts.items():
        dialog.lines[name].clear()
        qtbot.keyClicks(dialog.lines[name], text)


def test_a_data_sheet_makes_the_same_drone_as_the_command(dialog, qtbot, tmp_path, capsys):
    written = []
    dialog.written.connect(written.append)
    fill(dialog, qtbot, name="my_quad", mass="1.4kg", diagonal="450mm", propeller="10x4.5")
    fill(dialog, qtbot, motor_kv="920KV", battery="4S 5000mAh")
    dialog.sensors.setCurrentText("none")
    qtbot.mouseClick(dialog.make, LEFT)
    qtbot.waitUntil(lambda: bool(written))
    assert written == [tmp_path / "my_quad.urdf.xacro"]
    (tmp_path / "by_command").mkdir()
    other = tmp_path / "by_command" / "my_quad.urdf.xacro"
    command = f"new {other} --mass 1.4kg --diagonal 450mm --propeller 10x4.5 --motor-kv 920KV"
    assert main([*command.split(), "--battery", "4S 5000mAh"]) == 0
    assert written[0].read_text() == other.read_text()


def test_what_is_wrong_with_a_data_sheet_is_said_at_its_field(dialog, qtbot, tmp_path):
    (tmp_path / "taken.urdf.xacro").write_text("")
    good = {"name": "new", "mass": "1.4kg", "diagonal": "450mm", "propeller": "10x4.5"}
    for changed, said in (
        ({"name": "taken"}, "exists already"),
        ({"name": "../up"}, "no name of a file"),
        ({"max_thrust": "", "motor_kv": "920KV"}, "How strong are the motors"),
        ({"max_thrust": "850g", "mass": "1.4 stone"}, "no known unit"),
        ({"mass": ""}, "Mass, all-up is missing"),
        ({"diagonal": "200mm"}, "touch each other"),
        ({"max_thrust": "100g"}, "it cannot fly"),
    ):
        fill(dialog, qtbot, **(good | {"max_thrust": "850g"} | changed))
        qtbot.mouseClick(dialog.make, LEFT)
        qtbot.waitUntil(lambda said=said: said in dialog.fault.text())
    assert dialog.isVisible()
    assert [path.name for path in tmp_path.iterdir()] == ["taken.urdf.xacro"]
