"""Servos beside the sticks: keys and slider order setpoints, and follow what others set."""

import dataclasses

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest

from workbench.gui.joystick.servo_stick import KEY_STEPS, SLIDER_STEPS, ServoStick
from workbench.link.backplane import Published
from workbench.link.drone_topics import PARAMETERS_SIGNAL, fixed_topic
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.setup import make_setup


@pytest.fixture
def orders(workspace, monkeypatch):
    """Orders to a flight that is there."""
    found = []
    monkeypatch.setattr(type(workspace.flight), "live", property(lambda _: object()))

    def do(order, done, refused):
        found.append(order.set)
        done(0.0)

    monkeypatch.setattr(workspace.flight, "do", do)
    return found


@pytest.fixture
def stick(qtbot, workspace, canned, orders):
    setup = make_setup(Scenario(vehicle=VehicleConfig(model="gimbal")))
    made = ServoStick(workspace)
    qtbot.addWidget(made)
    made.view = dataclasses.replace(
        canned.views[-1], controller=setup.controller, values=setup.values
    )
    made.show_view(made.view)
    made.show()
    qtbot.waitActive(made)
    return made


def test_keys_and_slider_move_the_chosen_servo_within_its_range(stick, orders):
    names = [stick.servos.itemData(i) for i in range(stick.servos.count())]
    assert sorted(names) == ["servo_gimbal_pitch", "servo_gimbal_roll"]
    first, row = names[0], stick.chosen
    at = stick.slider.value()
    assert orders == []
    QTest.keyClick(stick, Qt.Key.Key_R)
    (order,) = orders
    span = row.maximum - row.minimum
    assert order == {first: pytest.approx(row.minimum + span * (at + KEY_STEPS) / SLIDER_STEPS)}
    QTest.keyClick(stick, Qt.Key.Key_F)
    assert stick.slider.value() == at
    stick.slider.setValue(SLIDER_STEPS)
    assert orders[-1] == {first: pytest.approx(row.maximum)}
    count = len(orders)
    QTest.keyClick(stick, Qt.Key.Key_R)
    assert len(orders) == count
    QTest.keyClick(stick, Qt.Key.Key_T)
    assert stick.servos.currentData() == names[1]
    assert len(orders) == count


def test_names_of_another_drone_s_servos_are_not_cut(stick):
    """The box was shown first with shorter names, those of an arm."""
    arm = make_setup(Scenario(vehicle=VehicleConfig(model="manipulator")))
    stick.begin(dataclasses.replace(stick.view, controller=arm.controller, values=arm.values))
    shorter = stick.servos.sizeHint().width()
    stick.begin(stick.view)
    widest = max(
        stick.servos.fontMetrics().horizontalAdvance(stick.servos.itemText(index))
        for index in range(stick.servos.count())
    )
    assert stick.servos.sizeHint().width() > max(shorter, widest)


def test_it_shows_what_a_client_sets_and_hides_without_servos(stick, workspace, canned, orders):
    row = stick.chosen
    packed = fixed_topic(PARAMETERS_SIGNAL.id).pack([row.name, row.maximum])
    workspace.flight.streamed.emit([Published(0, 0, ((PARAMETERS_SIGNAL.id, packed),))])
    assert stick.slider.value() == SLIDER_STEPS
    assert stick.reading.text().startswith(stick.slider.accessibleDescription())
    assert orders == []
    stick.show_view(canned.views[-1])
    assert stick.isHidden()
