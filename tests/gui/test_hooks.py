"""Loads on hooks in the real window: dropped and taken by key, menu and button, and shown."""

import dataclasses

import pytest
from PyQt6.QtCore import Qt

from tests.gui.conftest import view_of
from workbench.control.mode import FlightMode
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action, Scenario, VehicleConfig
from workbench.session.snapshot import CableStatus
from workbench.setup import make_setup

LEFT, CTRL = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.ControlModifier
TAUT = CableStatus("cable", (0.0, 0.0, 1.4), (0.0, 0.0, 0.4), 1.0, 1.96)
SLACK = dataclasses.replace(TAUT, tension=0.0)
DROP, TAKE = Action(set={"open_hooks": 1.0}), Action(set={"open_hooks": 0.0})


@pytest.fixture
def window(window):
    """With the sticks in front."""
    window.show_screen("joystick")
    return window


@pytest.fixture(scope="module")
def slung():
    """The shipped drone with a load on a cable."""
    return make_setup(Scenario(vehicle=VehicleConfig(model="slung_load"))).vehicle


@pytest.fixture
def carry(show, canned, slung):
    """Shows the drone with these cables."""
    view = view_of(canned, Phase.FLYING, FlightMode.HOVERING)

    def show_cables(*cables):
        snapshot = dataclasses.replace(view.snapshot, cables=cables)
        show(dataclasses.replace(view, vehicle=slung, snapshot=snapshot))

    return show_cables


def test_a_key_and_a_button_drop_the_load_and_take_it_again(window, orders, carry, qtbot):
    hooks, action = window.stack.current.state_bar.hooks, window.actions_by_name["open_hooks"]
    load = window.top_bar.strip.load
    carry(TAUT)
    assert hooks.isVisible() and hooks.text() == "Drop load"
    assert hooks.toolTip().endswith("(Ctrl+G)")
    assert load.isVisible() and load.text == "load hooked"
    assert action.isEnabled() and not action.isChecked()
    orders.clear()
    qtbot.keyClick(window.stack.current, Qt.Key.Key_G, CTRL)
    assert orders == [DROP]
    assert not action.isChecked()  # until the flight shows it
    carry()
    assert action.isChecked() and hooks.text() == "Take load" and load.text == "hooks open"
    qtbot.mouseClick(hooks, LEFT)
    assert orders == [DROP, TAKE]
    carry(SLACK)
    assert not action.isChecked() and load.text == "load hooked, slack"
    window.show_screen("home")
    action.trigger()
    assert orders == [DROP, TAKE, DROP]


def test_a_drone_without_hooks_has_none_of_it(window, orders, show, canned, qtbot):
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    assert not window.stack.current.state_bar.hooks.isVisible()
    assert not window.top_bar.strip.load.isVisible()
    assert not window.actions_by_name["open_hooks"].isEnabled()
    orders.clear()
    qtbot.keyClick(window.stack.current, Qt.Key.Key_G, CTRL)
    assert orders == []
