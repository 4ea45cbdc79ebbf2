"""Scheduled gains on the tuning screen: the sliders of the set that flies, and what judges it."""

import dataclasses

import pytest

from workbench.analysis.queries import FindRanges, Judge, Tune
from workbench.control.controller_file import load_controller
from workbench.gains.gain_choice import flight_gains
from workbench.gains.gains import GainFile, load_gains, save_gains
from workbench.gui.tuning.tuning_screen import TuningScreen
from workbench.scenario.scenario import Action

LAW = load_controller("pd@speed=0,4")


@pytest.fixture
def scheduled(flying):
    """The view of the drone with two sets of gains."""
    values = flight_gains(flying.vehicle, controller=LAW)
    names = [row.name for row in LAW.table]
    kept = {name: values[name] for name in names if name in flying.values or "_at_" in name}
    return dataclasses.replace(flying, controller=LAW, values=kept)


@pytest.fixture
def screen(offline, scheduled, qtbot):
    offline.preferences.set("apply_gains", "on Enter")
    offline.flight.show(scheduled)
    made = TuningScreen(offline)
    qtbot.addWidget(made)
    made.resize(1190, 600)
    made.begin(scheduled)
    made.show()
    yield made
    made.close_screen()


def at(view, speed):
    return dataclasses.replace(
        view, snapshot=dataclasses.replace(view.snapshot, v_WB=(speed, 0.0, 0.0))
    )


def shown(screen) -> set[str]:
    rows = screen.panel.rows
    return {name for name, row in rows.items() if "_at_" in name and row.isVisibleTo(screen.panel)}


def test_the_sliders_are_those_of_the_set_that_flies(screen, scheduled):
    every = {row.name for row in LAW.parameters if "_at_" in row.name}
    for speed, suffix in (
        (0.0, "_at_0"),
        (2.1, "_at_0"),
        (2.5, "_at_4"),
        (1.9, "_at_4"),
        (1.0, "_at_0"),
    ):
        screen.show_view(at(scheduled, speed))
        assert shown(screen) == {name for name in every if name.endswith(suffix)}, speed
    assert "speed 1.00 m/s, set at 0" in screen.panel.set_bar.flies.text()
    screen.panel.set_bar.choice.setCurrentIndex(2)
    screen.panel.set_bar.choice.activated.emit(2)
    screen.show_view(at(scheduled, 0.0))
    assert shown(screen) == {name for name in every if name.endswith("_at_4")}
    screen.panel.search.setText("roll")
    assert shown(screen) == {"kp_roll_at_4", "kd_roll_at_4"}
    assert screen.gains.words("kp_roll_at_4") == "Roll Kp at 4"


def test_a_set_stays_while_its_slider_is_held(screen, scheduled):
    screen.gains.begin_edit()
    screen.show_view(at(scheduled, 4.0))
    assert screen.gains.shown_set == 0
    screen.gains.end_edit()
    screen.show_view(at(scheduled, 4.0))
    assert screen.gains.shown_set == 1


def test_what_is_shown_is_judged_and_linked_within_its_set(screen, scheduled, qtbot):
    analysis = screen.workspace.analysis
    screen.show_view(at(scheduled, 4.0))
    screen.gains.set_linked(True)
    screen.gains.propose("kp_roll_at_4", 150.0)
    assert screen.gains.proposed["kp_pitch_at_4"] == 150.0
    assert screen.gains.proposed["kp_pitch_at_0"] != 150.0
    qtbot.waitUntil(
        lambda: bool(analysis.of(Judge)) and "kp_roll_at_4" in analysis.of(Judge)[-1].gains
    )
    asked = analysis.of(Judge)[-1].gains
    assert asked["kp_roll_at_4"] == 150.0 and not any(name.endswith("_at_0") for name in asked)
    qtbot.waitUntil(lambda: bool(analysis.of(FindRanges)))
    assert "kp_roll_at_4" in analysis.of(FindRanges)[-1].gains
    screen.autotune.search()
    (tune,) = analysis.of(Tune)
    assert tune.velocity == (4.0, 0.0, 0.0)
    assert {"kp_roll_at_0", "kp_roll_at_4"} <= set(tune.gains)


def test_a_gain_file_with_sets_of_gains_has_them_scheduled(
    screen, scheduled, tmp_path, qtbot, flying
):
    path = tmp_path / "fast.yaml"
    gains = {"kp_roll_at_0": 200.0, "kp_roll_at_4": 120.0}
    save_gains(path, GainFile(flying.vehicle.name, "by hand", gains, controller=LAW.name), LAW)
    plain = load_controller("pd")
    before = dataclasses.replace(
        flying, controller=plain, vehicle=dataclasses.replace(flying.vehicle)
    )
    screen.begin(before)
    orders = screen.workspace.flight.orders
    screen.gain_files.load(path)
    qtbot.waitUntil(lambda: Action(controller="pd@speed=0,4") in orders)
    screen.take_over(dataclasses.replace(scheduled, vehicle=flying.vehicle))
    assert screen.gain_files.diff is not None
    changed = {each.name: each.b for each in screen.gain_files.diff.changes}
    assert changed == gains
    screen.gain_files.take(changed)
    screen.gains.confirm()
    screen.gain_files.save(tmp_path / "saved.yaml")
    qtbot.waitUntil((tmp_path / "saved.yaml").exists)
    assert load_gains(tmp_path / "saved.yaml").controller == LAW.name


def test_a_schedule_that_is_none_is_a_sentence(screen, told):
    screen.gains.schedule_gains("speed=4,0")
    assert "ascending" in told[-1].what
    screen.gains.schedule_gains("")
    assert screen.workspace.flight.orders[-1] == Action(controller="pd")
