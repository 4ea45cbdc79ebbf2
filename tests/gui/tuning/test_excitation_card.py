import dataclasses

import numpy as np
import pytest
from PyQt6.QtCore import Qt

from workbench.control.mode import FlightMode
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import load_choice
from workbench.gui.tuning.response_card import command_line
from workbench.scenario.excitation import Excitation, Exciting, Shape


@pytest.fixture
def card(offline, flying, qtbot):
    offline.flight.show(flying)
    made = ExcitationCard(offline)
    qtbot.addWidget(made)
    made.show()
    made.begin()
    made.show_view(flying)
    return made


def in_mode(view, mode):
    return dataclasses.replace(view, snapshot=dataclasses.replace(view.snapshot, mode=mode))


def test_start_excites_the_flight_as_chosen(card, offline, qtbot):
    qtbot.mouseClick(card.button, Qt.MouseButton.LeftButton)
    wanted = Excitation("x", Shape.STEP, 1.0, 2.0, repeats=True)
    assert offline.flight.orders.given == [("excite", wanted)]


def test_it_can_be_excited_after_a_reset_in_the_air(card, flying):
    assert card.button.isEnabled()
    card.begin()
    card.show_view(flying)
    assert card.button.isEnabled() and not card.take_off.isVisible()


def test_one_key_starts_and_stops(card, offline, flying, qtbot):
    qtbot.keyClick(card, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    exciting = Exciting(card.choice.excitation, 3.0, 1)
    card.show_view(dataclasses.replace(flying, exciting=exciting))
    assert card.button.text() == "Stop"
    qtbot.keyClick(card, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    assert [order[0] for order in offline.flight.orders.given] == ["excite", "stop_exciting"]


def test_everything_can_be_chosen_by_keyboard(card, offline, qtbot):
    for box, times in ((card.axis, 2), (card.shape, 1)):
        box.setFocus()
        for _ in range(times):
            qtbot.keyClick(box, Qt.Key.Key_Down)
    for field, text in ((card.amplitude, "0.5"), (card.period, "3")):
        field.setFocus()
        field.selectAll()
        qtbot.keyClicks(field, text)
        qtbot.keyClick(field, Qt.Key.Key_Return)
    qtbot.keyClick(card.repeats, Qt.Key.Key_Space)
    assert card.choice.excitation == Excitation("z", Shape.DOUBLET, 0.5, 3.0, repeats=False)
    assert load_choice(offline.preferences.store) == card.choice


def test_the_flights_limits_are_bounds(card, flying):
    assert card.amplitude.maximum() == pytest.approx(flying.values["max_speed"])
    card.axis.setCurrentIndex(3)
    card.axis.activated.emit(3)
    assert card.amplitude.maximum() == pytest.approx(
        np.degrees(flying.values["max_yaw_rate"]), 1e-2
    )
    assert card.amplitude.suffix().strip() == "°/s"
    assert card.choice.amplitude == pytest.approx(0.2)


def test_each_axis_keeps_its_own_amplitude(card):
    card.amplitude.setValue(2.5)
    card.axis.activated.emit(2)
    assert card.amplitude.value() == 1.0
    card.axis.activated.emit(0)
    assert card.amplitude.value() == 2.5


def test_nothing_is_no_amplitude(card):
    card.amplitude.lineEdit().setText("0")
    card.amplitude.interpretText()
    assert "out of range" in card.amplitude.fault
    assert card.choice.amplitude == card.amplitude.si == 1.0
    card.amplitude.stepBy(-10)
    assert card.choice.amplitude == card.amplitude.si == pytest.approx(-0.1)


def test_on_the_ground_it_offers_to_take_off(card, offline, flying, qtbot):
    card.show_view(in_mode(flying, FlightMode.OFF))
    assert not card.button.isEnabled()
    assert card.said.text() == "The drone must hover: take off."
    qtbot.mouseClick(card.take_off, Qt.MouseButton.LeftButton)
    assert offline.flight.orders.given == [("request", "take_off")]
    card.show_view(in_mode(flying, FlightMode.HOVERING))
    assert card.take_off.isHidden()
    assert card.button.isEnabled()


def test_nothing_can_be_started_before_there_is_a_flight(offline, qtbot):
    card = ExcitationCard(offline)
    qtbot.addWidget(card)
    assert card.said.text() == "Nothing flies yet."
    assert not card.button.isEnabled()


def test_it_says_how_far_the_drone_will_go(card):
    assert card.said.text() == "2.0 m along x, and back"


def test_what_is_changed_while_it_runs_is_flown(card, offline, flying):
    card.show_view(dataclasses.replace(flying, exciting=Exciting(card.choice.excitation, 3.0, 1)))
    card.amplitude.setValue(2.0)
    assert offline.flight.orders.given[-1][1].amplitude == 2.0


def test_nonsense_that_was_kept_is_left_alone(offline):
    offline.preferences.store.setValue("tuning/excitation/period", "soon")
    offline.preferences.store.setValue("tuning/excitation/axis", "w")
    assert load_choice(offline.preferences.store).period == 2.0


@pytest.mark.parametrize("shape", list(Shape))
def test_the_line_of_the_command_is_what_is_flown(shape):
    excitation = Excitation("x", shape, 1.5, 2.0)
    time, values = command_line(excitation)
    for at in np.linspace(0.013, excitation.round_time - 0.013, 40):
        before = np.searchsorted(time, at) - 1
        flown = excitation.command(float(at))
        drawn = np.interp(at, time, values) if shape is Shape.CHIRP else values[before]
        assert drawn == pytest.approx(flown, abs=0.01), at
