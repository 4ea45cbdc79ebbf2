"""The first minutes: each hint stays until what it says was done."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from PyQt6.QtCore import Qt

from workbench.control.mode import FlightMode
from workbench.gui.banner import GUIDE_DONE_KEY, GUIDE_END_TEXT, BeginnerGuide
from workbench.scenario.excitation import ActiveExcitation, Excitation, Shape
from workbench.scenario.scenario import Action, Scenario

FLOWN = ActiveExcitation(Excitation("x", Shape.STEP, 1.0, 4.0), 3.0, 1)


@pytest.fixture
def gains():
    return SimpleNamespace(tried=(), flown={"kp_velocity_x": 5.0})


@pytest.fixture
def guide(workspace, gains, qtbot):
    store = workspace.preferences.store
    store.remove(GUIDE_DONE_KEY)
    guide = BeginnerGuide(workspace.flight, store, lambda: gains)
    qtbot.addWidget(guide)
    guide.begin()
    return guide


@pytest.fixture
def show(workspace, canned):
    def show_view(mode=FlightMode.HOVERING, **changes):
        snapshot = replace(canned.views[0].snapshot, mode=mode)
        workspace.flight.viewed.emit(replace(canned.views[0], snapshot=snapshot, **changes))

    return show_view


def stage(guide):
    first = guide.accessibleName()[0]
    return int(first) if not guide.isHidden() and first.isdigit() else 0


def test_it_goes_on_once_each_was_done_and_goes_when_it_is_closed(guide, gains, show, qtbot):
    height = guide.sizeHint().height()
    assert guide.wanted and stage(guide) == 1
    show(FlightMode.OFF)
    show(FlightMode.TAKING_OFF)
    assert stage(guide) == 1
    show()
    assert stage(guide) == 2
    show(exciting=FLOWN)
    show(excitation_ended="a wall is too near")  # not flown to its end
    assert stage(guide) == 2
    show(exciting=FLOWN)
    show()
    assert stage(guide) == 3
    show()
    assert stage(guide) == 3
    gains.tried = ("kp_velocity_x",)
    show()
    assert stage(guide) == 4
    show()
    assert stage(guide) == 4
    gains.tried = ()
    show()
    assert stage(guide) == 0 and GUIDE_END_TEXT in guide.accessibleName()
    assert not guide.wanted and not guide.isHidden()
    assert guide.sizeHint().height() == height
    show()
    qtbot.mouseClick(guide.skip, Qt.MouseButton.LeftButton)
    assert guide.isHidden()


def test_one_step_of_those_that_repeat_is_enough(guide, show):
    show()
    for flown in (replace(FLOWN, round=0), FLOWN):
        show(exciting=flown)
        assert stage(guide) == 2
    show(exciting=replace(FLOWN, returning=True))
    assert stage(guide) == 3


def test_a_gain_that_the_script_sets_is_not_moved_by_the_user(guide, gains, show):
    scenario = Scenario(script=[Action(at=1.0, set={"kp_velocity_x": 5.0})])
    for each in ({}, {"exciting": FLOWN}, {}):
        show(**each)
    gains.tried = ("kp_velocity_x",)
    show(scenario=scenario)
    assert stage(guide) == 3
    gains.flown = {"kp_velocity_x": 5.5}
    show(scenario=scenario)
    assert stage(guide) == 4


def test_it_can_be_skipped_for_good(guide, show, qtbot):
    qtbot.mouseClick(guide.skip, Qt.MouseButton.LeftButton)
    assert guide.isHidden() and not guide.wanted
    show()
    assert guide.isHidden()
