import dataclasses

import numpy as np
import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QAbstractButton

from workbench.control.mode import FlightMode
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.tuning.excitation_form import EXCITATION_KINDS, load_choice
from workbench.gui.tuning.step_part import command_curve
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape
from workbench.scenario.scenario import Action


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
    assert offline.flight.orders == [wanted]


def test_it_can_be_excited_after_a_reset_in_the_air(card, flying):
    assert card.button.isEnabled()
    card.begin()
    card.show_view(flying)
    assert card.button.isEnabled() and not card.take_off.isVisible()


def test_a_flight_that_has_ended_is_not_excited(card, flying):
    card.show_view(dataclasses.replace(flying, phase=Phase.ENDED))
    assert not card.button.isEnabled() and not card.take_off.isVisible()
    assert card.said.text() == "The flight has ended: reset it."


def test_one_key_starts_and_stops(card, offline, flying, qtbot):
    qtbot.keyClick(card, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    exciting = ActiveExcitation(card.choice.excitation, 3.0, 1)
    card.show_view(dataclasses.replace(flying, exciting=exciting))
    assert card.button.text() == "Stop"
    qtbot.keyClick(card, Qt.Key.Key_E, Qt.KeyboardModifier.ControlModifier)
    assert offline.flight.orders == [card.choice.excitation, FlightOrder.STOP_EXCITING]


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
    assert offline.flight.orders == [Action(request="take_off")]
    card.show_view(in_mode(flying, FlightMode.HOVERING))
    assert card.take_off.isHidden()
    assert card.button.isEnabled()


def test_what_stays_keeps_its_place_when_take_off_goes(card, flying, qtbot):
    """A second click on Take off meets no other button."""
    card.show_view(in_mode(flying, FlightMode.OFF))
    qtbot.wait(1)
    stays = (card.repeats, card.button, card.tabs, card.amplitude)
    before = [each.mapTo(card, each.rect().topLeft()) for each in stays]
    middle = card.take_off.mapTo(card, card.take_off.rect().center())
    card.show_view(in_mode(flying, FlightMode.TAKING_OFF))
    qtbot.wait(1)
    assert [each.mapTo(card, each.rect().topLeft()) for each in stays] == before
    assert not isinstance(card.childAt(middle), QAbstractButton)


def test_a_drone_that_moves_comes_to_rest_first(card, flying):
    waits = ActiveExcitation(card.choice.excitation, 3.0, 0)
    card.show_view(dataclasses.replace(flying, exciting=waits))
    assert card.said.text() == "Coming to rest before the first step."
    drifting = dataclasses.replace(waits, drifts=True)
    card.show_view(dataclasses.replace(flying, exciting=drifting))
    assert card.said.text() == "Drifting with the wind until that is steady."
    for waited, said in ((12.9, "12 s"), (13.0, "13 s")):
        swinging = dataclasses.replace(flying, exciting=dataclasses.replace(waits, waited=waited))
        card.show_view(swinging)
        assert card.said.text() == f"Waiting until it no longer swings: {said}, 60 s at most."
    assert card.button.text() == "Stop"


def test_nothing_can_be_started_before_there_is_a_flight(offline, qtbot):
    card = ExcitationCard(offline)
    qtbot.addWidget(card)
    assert card.said.text() == "Nothing flies yet: open a scenario."
    assert not card.button.isEnabled()


def test_it_says_how_far_the_drone_will_go(card):
    assert card.said.text() == "2.0 m along x, and back"


def test_what_is_changed_while_it_runs_is_flown(card, offline, flying):
    card.show_view(
        dataclasses.replace(flying, exciting=ActiveExcitation(card.choice.excitation, 3.0, 1))
    )
    card.amplitude.setValue(2.0)
    assert offline.flight.orders[-1].amplitude == 2.0


def test_nonsense_that_was_kept_is_left_alone(offline):
    offline.preferences.store.setValue("tuning/excitation/period", "soon")
    offline.preferences.store.setValue("tuning/excitation/axis", "w")
    assert load_choice(offline.preferences.store).period == 2.0


@pytest.mark.parametrize("shape", list(Shape))
def test_the_line_of_the_command_is_what_is_flown(shape):
    excitation = Excitation("x", shape, 1.5, 2.0)
    time, values = command_curve(excitation)
    for at in np.linspace(0.013, excitation.round_time - 0.013, 40):
        before = np.searchsorted(time, at) - 1
        flown = excitation.command(float(at))
        drawn = np.interp(at, time, values) if shape is Shape.CHIRP else values[before]
        assert drawn == pytest.approx(flown, abs=0.01), at


def test_attitude_is_excited_within_the_tilt_and_only_where_the_law_has_it(
    card, offline, flying, qtbot
):
    card.tabs.setCurrentIndex([kind.name for kind in EXCITATION_KINDS].index("Attitude"))
    assert [card.axis.itemText(i) for i in range(card.axis.count())] == [
        "roll",
        "pitch",
        "roll rate",
        "pitch rate",
    ]
    assert card.amplitude.maximum() == pytest.approx(
        np.degrees(flying.values["max_tilt"]), abs=0.01
    )
    qtbot.mouseClick(card.button, Qt.MouseButton.LeftButton)
    assert offline.flight.orders == [Excitation("roll", Shape.STEP, 0.1, 1.0, repeats=True)]
    card.axis.setCurrentIndex(2)
    card.axis.activated.emit(2)
    assert not card.button.isEnabled()
    assert "pd has no loop that follows a setpoint of roll rate" in card.said.text()
