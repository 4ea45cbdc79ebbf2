"""A real flight behind the model: begun, ordered, broken, replaced and ended."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.gui.flight_control import FlightControl
from workbench.gui.flight_model import since_last_restart
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder, SetSpeed
from workbench.scenario.scenario import Action, Scenario

START = 60_000
OWN = Path(__file__).parents[1] / "controllers/cascade.py"


@pytest.fixture
def heard(workspace):
    begun, phases = [], []
    workspace.flight.begun.connect(begun.append)
    workspace.flight.phase_changed.connect(phases.append)
    return begun, phases


def test_a_flight_begins_obeys_and_begins_anew(workspace, heard, told, qtbot):
    begun, phases = heard
    flight = workspace.flight
    flight.fly(Choice("hover"), draw=False)
    assert not flight.is_flying
    qtbot.waitUntil(lambda: bool(begun), timeout=START)
    assert begun[0].scenario.title == "Hover for a minute"
    assert flight.is_flying
    qtbot.waitUntil(lambda: workspace.signals.now > 0.5, timeout=START)
    time, v_z = workspace.signals.series("velocity_data.v_z")
    assert len(time) > 50

    answered, refused = [], []
    flight.do(Action(set={"max_tilt": 0.3}), answered.append)
    flight.do(Action(set={"max_tilt": 99.0}), None, refused.append)
    flight.do(Action(set={"max_tlt": 0.3}))
    qtbot.waitUntil(lambda: bool(answered and refused and told), timeout=START)
    assert "within" in refused[0] and "max_tlt" in told[0].what

    flight.do(FlightOrder.RESET)
    qtbot.waitUntil(lambda: len(begun) == 2, timeout=START)
    assert begun[1].snapshot.time < 0.5


@pytest.mark.slow
def test_another_controller_takes_over_in_flight_and_charts_go_on(
    workspace, heard, told, qtbot, tmp_path
):
    begun, _ = heard
    flight, taken = workspace.flight, []
    flight.taken_over.connect(taken.append)
    control = FlightControl(flight, workspace.preferences)
    file = tmp_path / "mine.py"
    text = OWN.read_text(encoding="utf-8")
    file.write_text(text, encoding="utf-8")
    flight.fly(Choice("hover"), draw=False)
    qtbot.waitUntil(lambda: workspace.signals.now > 0.2, timeout=START)
    live = flight.live
    control.fly_controller(str(file))
    qtbot.waitUntil(lambda: len(taken) == 1, timeout=START)
    file.write_text(text.replace("def update(", "def update(:"), encoding="utf-8")
    qtbot.waitUntil(lambda: any("is not valid Python" in each.what for each in told), timeout=START)
    file.write_text(text + "# edited\n", encoding="utf-8")
    qtbot.waitUntil(lambda: len(taken) == 2, timeout=START)
    control.fly_controller("lqi")
    qtbot.waitUntil(lambda: len(taken) == 3, timeout=START)
    assert [view.controller.name for view in taken] == ["mine", "mine", "lqi"]
    assert flight.live is live and len(begun) == 1
    at = workspace.signals.now
    qtbot.waitUntil(lambda: workspace.signals.now > at + 0.2, timeout=START)
    time, _ = workspace.signals.series("velocity_data.v_z")
    assert time[0] < 0.1 and (np.diff(time) > 0.0).all()
    assert flight.what.controller == "lqi"


@pytest.mark.slow
def test_what_a_flight_warns_of_is_a_notice(workspace, heard, told, qtbot):
    begun, _ = heard
    flight = workspace.flight
    flight.fly(Choice("hover"), draw=False)
    qtbot.waitUntil(lambda: bool(begun), timeout=START)
    # 1 % a second, and so little above the reserve that it is used up at once
    flight.do(Action(set={"battery_duration": 100.0, "battery_reserve": 0.9}))
    flight.do(SetSpeed(10.0))
    qtbot.waitUntil(lambda: len(told) >= 2, timeout=START)
    said = [notice.what.replace("\N{NO-BREAK SPACE}", " ") for notice in told]
    assert said[0].endswith("the drone lands at 90 %") and said[0].startswith("battery low: ")
    assert said[1] == "battery empty: the drone lands with the last 90 %"


def test_after_a_reset_only_samples_of_the_new_flight_are_shown(canned):
    old = [part for parts in canned.published[100:103] for part in parts]
    new = [part for parts in canned.published[:3] for part in parts]
    assert since_last_restart([*old, *new], canned.views[2]) == new
    assert since_last_restart(new, canned.views[2]) == new
    assert since_last_restart(old, canned.views[2]) == []


def test_without_a_flight_an_order_is_a_sentence(workspace, told):
    workspace.flight.do(FlightOrder.PAUSE)
    assert "nothing flies" in told[0].what


def test_who_hears_of_a_view_may_end_the_flight(workspace, canned, monkeypatch):
    """As SIGTERM does: the window closes while it is told of what is new."""
    flight = workspace.flight
    live = SimpleNamespace(
        streamed=list, latest=lambda: canned.views[0], missed=7, close=lambda *_: None
    )
    monkeypatch.setattr(flight, "_live", live)
    flight.viewed.connect(lambda _: setattr(flight, "_live", None))
    flight._look()
    assert flight.live is None


def test_a_controller_that_begins_a_flight_has_not_taken_over(
    workspace, heard, canned, monkeypatch
):
    """The process has said what flies, and has not shown it yet."""
    begun, _ = heard
    flight, taken = workspace.flight, []
    flight.taken_over.connect(taken.append)
    view = replace(canned.views[0], controller=load_controller())
    views = iter(
        [replace(view, snapshot=None), view, replace(view, controller=load_controller("pid"))]
    )
    live = SimpleNamespace(
        streamed=list, latest=lambda: next(views), missed=0, close=lambda *_: None
    )
    monkeypatch.setattr(flight, "_live", live)
    flight._look()
    flight._look()
    assert (len(begun), len(taken)) == (1, 0)
    flight._look()
    assert (len(begun), len(taken)) == (1, 1)
    monkeypatch.setattr(flight, "_live", None)


@pytest.mark.slow
def test_a_reset_is_noticed_where_time_stands_at_the_start(workspace, heard, qtbot):
    begun, _ = heard
    flight = workspace.flight
    flight.fly(Choice("hover"), draw=False)
    flight.do(FlightOrder.PAUSE)
    flight.do(FlightOrder.RESET)
    qtbot.waitUntil(lambda: bool(begun) and begun[-1].snapshot.time == 0.0, timeout=START)
    before = len(begun)
    flight.do(FlightOrder.RESET)
    qtbot.waitUntil(lambda: len(begun) > before, timeout=START)
    assert begun[-1].snapshot.time == 0.0
    assert begun[-1].phase is Phase.PAUSED


@pytest.mark.slow
def test_what_a_flight_refuses_that_was_replaced_is_not_told(workspace, heard, told, qtbot):
    begun, _ = heard
    flight, refused = workspace.flight, []
    flight.fly(Choice("hover"), draw=False)
    flight.do(Action(set={"max_tilt": 0.3}))
    flight.do(Action(set={"max_tilt": 0.3}), None, refused.append)
    flight.fly(Choice("hover"), draw=False)
    qtbot.waitUntil(lambda: bool(begun and refused), timeout=START)
    assert refused == ["the flight is closed"]
    assert told == []


def test_a_flight_that_gets_no_process_takes_the_place_of_the_one_before(
    workspace, heard, told, monkeypatch
):
    def refuse(*_, **__):
        raise WorkbenchError("no process can be started")

    workspace.flight.fly(Choice("hover"), draw=False)
    monkeypatch.setattr("workbench.gui.flight_model.LiveFlight", refuse)
    workspace.flight.fly(Choice("hover"), draw=False)
    assert workspace.flight.view.phase is Phase.ENDED
    assert [each.what for each in told] == ["no process can be started"]


def test_what_cannot_be_flown_is_told_and_the_next_flies(workspace, heard, told, qtbot):
    begun, _ = heard
    workspace.flight.fly(Scenario(world="nowhere"), draw=False)
    qtbot.waitUntil(lambda: bool(told), timeout=START)
    assert "nowhere" in told[0].what and told[0].remedy
    assert workspace.flight.view.phase is Phase.ENDED
    workspace.flight.fly(Scenario(), draw=False)
    qtbot.waitUntil(lambda: bool(begun), timeout=START)
    assert workspace.flight.is_flying


def test_a_gap_in_what_was_published_is_told_once(workspace, told):
    live = SimpleNamespace(
        streamed=lambda: [], latest=lambda: workspace.flight.view, missed=0, close=lambda: None
    )
    workspace.flight._live = live
    for missed in (0, 3, 3):
        live.missed = missed
        workspace.flight._look()
    assert [each.what for each in told] == [
        "The window was busy for so long that the charts have a gap."
    ]
