"""Loads, pushes, gusts, wind and faults: by the mouse on the real card, and in a real flight."""

import dataclasses
import math

import numpy as np
import pytest
from PyQt6.QtCore import QSettings, Qt

from workbench.analysis.queries import Predict, RequestedStep
from workbench.control.mode import FlightMode
from workbench.design.load_metrics import LoadMetrics
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import EXCITATION_KINDS, load_choice, load_kind
from workbench.gui.tuning.limits import LOAD_LIMITS, LOAD_PEAKS
from workbench.gui.tuning.metric_row import metric_rows, step_limits_of
from workbench.gui.tuning.number_row import RowState
from workbench.gui.tuning.round_trace import RoundTrace
from workbench.gui.tuning.step_part import StepPart, measure_load, step_parts
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.gui.workspace import make_workspace
from workbench.live.choice import Choice
from workbench.live.orders import FlightOrder
from workbench.scenario.excitation import PULSE_RETURN_TIME_S, ActiveExcitation, Excitation, Shape
from workbench.scenario.loads import find_load

LIMIT = 600_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def card(offline, flying, qtbot):
    offline.flight.show(flying)
    made = ExcitationCard(offline)
    qtbot.addWidget(made)
    made.show()
    made.begin()
    made.show_view(flying)
    return made


def choose(card, name, qtbot):
    """Click on a tab."""
    names = [card.tabs.tabText(index) for index in range(card.tabs.count())]
    place = card.tabs.tabRect(names.index(name)).center()
    qtbot.mouseClick(card.tabs, LEFT, pos=place)


def test_a_push_and_a_gust_are_excitations_with_a_strength_and_a_direction(card, offline, qtbot):
    choose(card, "Push", qtbot)
    assert card.button.text() == "Push now"
    qtbot.mouseClick(card.button, LEFT)
    choose(card, "Gust", qtbot)
    card.axis.setFocus()
    qtbot.keyClick(card.axis, Qt.Key.Key_Down)
    card.amplitude.setFocus()
    card.amplitude.selectAll()
    qtbot.keyClicks(card.amplitude, "-6")
    qtbot.keyClick(card.amplitude, Qt.Key.Key_Return)
    qtbot.mouseClick(card.button, LEFT)
    choose(card, "Load", qtbot)
    card.axis.activated.emit(5)
    qtbot.mouseClick(card.button, LEFT)
    assert offline.flight.orders == [
        Excitation("force_x", Shape.PULSE, 5.0, 0.2),
        Excitation("gust_y", Shape.PULSE, -6.0, 1.0),
        Excitation("torque_yaw", Shape.STEP, 0.02, 4.0, repeats=True),
    ]
    store = offline.preferences.store
    assert load_kind(store).name == "Load"
    assert [load_choice(store, kind).axis for kind in EXCITATION_KINDS] == [
        "x",
        "roll",
        "torque_yaw",
        "force_x",
        "gust_y",
    ]


def test_another_tab_leaves_what_runs_alone_and_can_stop_it(card, offline, flying, qtbot):
    exciting = ActiveExcitation(card.choice.excitation, 3.0, 1)
    card.show_view(dataclasses.replace(flying, exciting=exciting))
    for name in ("Load", "Wind"):
        choose(card, name, qtbot)
        assert card.button.isVisible() and card.button.text() == "Stop"
    assert offline.flight.orders == []
    qtbot.mouseClick(card.button, LEFT)
    assert offline.flight.orders == [FlightOrder.STOP_EXCITING]


def test_wind_and_turbulence_are_set_by_name_and_stilled(card, offline, qtbot):
    choose(card, "Wind", qtbot)
    assert not card.axis.isVisible() and not card.repeats.isVisible()
    card.wind.speed.show_si(6.0)
    card.wind.direction.show_si(math.radians(90.0))
    card.wind.turbulence.setCurrentText("moderate")
    qtbot.mouseClick(card.wind.button, LEFT)
    qtbot.mouseClick(card.wind.still, LEFT)
    blown, still = (order.set for order in offline.flight.orders)
    wanted = {"wind_x": 0.0, "wind_y": 6.0, "wind_z": 0.0, "turbulence": 15.4}
    assert blown == pytest.approx(wanted, abs=1e-9)
    assert set(still.values()) == {0.0}


def test_a_fault_has_a_name_and_is_repaired(card, offline, qtbot):
    choose(card, "Fault", qtbot)
    assert card.said.text() == "Nothing has failed."
    card.fault.part.setCurrentText("gps")
    card.fault.mode.setCurrentText("silent")
    assert not card.fault.repair.isEnabled()

    def click(button):
        """Click; the flight publishes what it carried out."""
        qtbot.mouseClick(button, LEFT)
        card.fault.follow(offline.flight.orders[-1].set)

    click(card.fault.button)
    card.fault.part.setCurrentText("rotor 3")
    assert card.fault.share.isVisible() and not card.fault.mode.isVisible()
    card.fault.share.show_si(0.65)
    click(card.fault.button)
    assert card.said.text() == "Failed: rotor 3 at 65 %, gps silent."
    click(card.fault.repair)
    assert card.said.text() == "Failed: gps silent."
    assert [order.set for order in offline.flight.orders] == [
        {"gps_fault": 3.0},
        {"rotor_3": 0.65},
        {"rotor_3": 1.0},
    ]
    card.begin()
    assert card.fault.said == ""
    qtbot.mouseClick(card.fault.button, LEFT)
    assert card.fault.said == ""  # a flight that has ended answers late, and publishes nothing more


def test_a_flown_load_is_measured_and_held_to_limits():
    """A second-order answer by hand: t exp(-a t), whose peak is at 1/a."""
    excitation = Excitation("torque_pitch", Shape.PULSE, 0.5, 0.2)
    (part,) = step_parts(excitation)
    assert part == StepPart(0.0, 0.2 + PULSE_RETURN_TIME_S, 0.0, 0.5)
    time = np.arange(0.0, part.end, 1 / 204.8)
    assert time[-1] < part.end - 1e-3  # no sample falls on its end
    still = np.zeros(len(time))
    rise = 0.2 * time * np.exp(-4.0 * time)
    numbers = measure_load(RoundTrace(time, rise + 0.3, still, still + 0.7), part)
    assert numbers.peak == pytest.approx(0.05 / math.e, rel=1e-3)
    assert numbers.peak_rotor_use == 0.7
    assert measure_load(RoundTrace(time[:300], rise[:300], still[:300], still[:300]), part) is None
    limits = step_limits_of(find_load("torque_pitch"))
    rows = metric_rows(numbers, None, lambda name: 1.0, limits)
    assert [row.label for row in rows] == ["Peak", "Settling time", "Steady error", "Rotor use"]
    assert rows[0].cells[0].text == f"{math.degrees(0.05 / math.e):.3f}"
    assert rows[0].state is RowState.OVER and rows[0].cells[2].text == "≤ 1°"
    units = {"force_x": "m", "gust_z": "m", "torque_roll": "rad", "torque_yaw": "rad/s"}
    for name, unit in units.items():
        assert step_limits_of(find_load(name)) == (LOAD_PEAKS[unit], *LOAD_LIMITS)


def test_a_load_is_predicted_and_what_needs_a_setpoints_step_asks_for_none(offline, flying, qtbot):
    offline.preferences.set("apply_gains", "on Enter")
    offline.flight.show(flying)
    screen = TuningScreen(offline)
    qtbot.addWidget(screen)
    screen.begin(flying)
    screen.show()
    assert isinstance(screen.trial.step, RequestedStep)
    choose(screen.excitation, "Push", qtbot)
    qtbot.waitUntil(lambda: screen.trial.step is None)
    wanted = RequestedStep("force_x", 5.0, 0.2 + PULSE_RETURN_TIME_S, acts=0.2)
    assert dataclasses.replace(screen.trial.excited, heading=0.0) == wanted
    qtbot.waitUntil(lambda: screen.trial.excited in [q.step for q in offline.analysis.of(Predict)])
    response = screen.response
    assert response.load_form.button.isVisibleTo(response)
    assert not response.form.button.isVisibleTo(response)
    choose(screen.excitation, "Setpoint", qtbot)
    assert isinstance(screen.trial.step, RequestedStep)
    screen.close_screen()


@pytest.mark.slow
def test_push_now_is_flown_measured_and_as_predicted(qtbot, tmp_path):
    """In the real window, with a real flight and analyst: within 5 %, and in the script."""
    store = QSettings(str(tmp_path / "kept.ini"), QSettings.Format.IniFormat)
    workspace = make_workspace(Preferences(store))
    window = MainWindow(workspace, first="tuning", view3d=False)
    qtbot.addWidget(window)
    window.show()
    window.control.fly(Choice(world="empty"))
    flight = workspace.flight

    def until(so):
        qtbot.waitUntil(lambda: bool(so()), timeout=LIMIT)

    until(lambda: flight.is_flying and flight.view.snapshot is not None)
    screen = window.stack.screen_of("tuning")
    card, response = screen.excitation, screen.response
    until(lambda: screen.gains.flown)
    if flight.view.snapshot.mode is FlightMode.OFF:
        qtbot.mouseClick(card.take_off, LEFT)
    until(lambda: flight.view.snapshot.mode is FlightMode.HOVERING)
    until(lambda: math.hypot(*flight.view.snapshot.v_WB) < 1e-3)
    for name in ("Push", "Gust"):
        choose(card, name, qtbot)
        until(card.button.isEnabled)
        qtbot.mouseClick(card.button, LEFT)
        until(lambda: response.history.numbers is not None and response._predicted is not None)
        until(lambda: response._predicted_step == response.step)
        flown, predicted = response.history.numbers, response._predicted.numbers
        assert isinstance(flown, LoadMetrics)
        assert flown.peak == pytest.approx(predicted.peak, rel=0.05)
        assert flown.settling_time == pytest.approx(predicted.settling_time, rel=0.05)
        until(lambda: flight.view.exciting is None)
    found = []
    flight.do(FlightOrder.GET_FLOWN, found.append)
    until(lambda: found)
    script = found[0].scenario.script
    assert [action.push.force[0] for action in script if action.push is not None][:2] == [5.0, 0.0]
    assert [action.gust.velocity[0] for action in script if action.gust is not None][0] == 5.0
    window.close()
