"""Settings by keyboard and mouse; limits and set-ups reach the flight as orders."""

from concurrent.futures import Future
from dataclasses import replace

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QAbstractSpinBox, QComboBox, QLabel, QLineEdit, QWidget

from workbench.control.controller_file import load_controller
from workbench.gui.first_flight import last_setup
from workbench.gui.joystick.handling_panel import HandlingPanel
from workbench.gui.number_field import NumberField
from workbench.gui.preferences import PREFERENCES
from workbench.gui.settings.limit_row import LIMIT_SETTINGS
from workbench.gui.settings.setting_row import PreferenceRow
from workbench.gui.settings.settings_screen import SettingsScreen
from workbench.scenario.scenario import Rates, SensorsConfig
from workbench.scenario.scenario_file import load_scenario


class FakeLive:
    """Keeps what is ordered."""

    def __init__(self):
        self.orders = []

    def do(self, order):
        self.orders += order.set.items()
        answer = Future()
        answer.set_result(0.0)
        return answer

    def close(self):
        """End nothing."""


@pytest.fixture
def live(workspace):
    workspace.flight._live = FakeLive()
    return workspace.flight._live


@pytest.fixture
def screen(workspace, qtbot):
    made = SettingsScreen(workspace)
    qtbot.addWidget(made)
    made.resize(760, 600)
    made.show()
    return made


def row_of(screen, name):
    return next(row for row in screen.findChildren(PreferenceRow) if row.preference.name == name)


@pytest.mark.parametrize("typed", [None, "21.75", "30"])
def test_a_turning_rate_reads_as_on_the_joystick_screen(screen, workspace, qtbot, typed):
    sticks = HandlingPanel(workspace.preferences, workspace.look)
    qtbot.addWidget(sticks)
    field = row_of(screen, "stick_yaw_rate").findChild(NumberField)
    if typed is not None:
        field.setFocus()
        field.selectAll()
        qtbot.keyClicks(field, typed)
        qtbot.keyClick(field, Qt.Key.Key_Return)
    shown = [each.text() for each in sticks.findChildren(QLabel)]
    assert field.text() in shown
    assert field.text().startswith(typed or "22.918\N{NO-BREAK SPACE}")


def test_every_preference_has_a_row_with_a_name_for_readers(screen):
    assert len(screen.findChildren(PreferenceRow)) == len(PREFERENCES)
    kinds = (QAbstractSpinBox, QComboBox, QLineEdit)
    for kind in kinds:
        for control in screen.findChildren(kind):
            inner = isinstance(control.parent(), QAbstractSpinBox | QComboBox)
            assert inner or control.accessibleName(), control


def test_a_typed_number_is_kept_in_si(screen, workspace, qtbot):
    box = row_of(screen, "stick_yaw_rate").findChild(QAbstractSpinBox)
    box.selectAll()
    qtbot.keyClicks(box, "90")
    qtbot.keyClick(box, Qt.Key.Key_Return)
    assert workspace.preferences.number("stick_yaw_rate") == pytest.approx(1.5708, abs=1e-3)
    assert row_of(screen, "stick_yaw_rate").reset.isEnabled()
    qtbot.mouseClick(row_of(screen, "stick_yaw_rate").reset, Qt.MouseButton.LeftButton)
    assert workspace.preferences.number("stick_yaw_rate") == 0.4


def test_numbers_are_written_as_on_other_screens(screen, case):
    """A share is a percentage beside the sticks and on the battery, too."""
    for name, text in (
        ("stick_sensitivity", "100\N{NO-BREAK SPACE}%"),
        ("stick_dead_band", "5\N{NO-BREAK SPACE}%"),
        ("stick_speed", "8.00\N{NO-BREAK SPACE}m/s"),
    ):
        with case(name):
            assert row_of(screen, name).findChild(QAbstractSpinBox).text() == text


def test_a_number_follows_the_unit_that_is_preferred(screen, workspace):
    workspace.preferences.set("stick_yaw_rate", 0.5)
    box = row_of(screen, "stick_yaw_rate").findChild(QAbstractSpinBox)
    workspace.preferences.set("angle_unit", "radian")
    assert box.text() == "0.500\N{NO-BREAK SPACE}rad/s"
    assert "rad/s" in box.accessibleName()
    workspace.preferences.set("angle_unit", "degree")
    assert box.text().startswith("28.6") and box.text().endswith("°/s")
    assert workspace.preferences.number("stick_yaw_rate") == 0.5


def test_a_choice_takes_effect_at_once(screen, workspace, qtbot):
    box = row_of(screen, "theme").findChild(QComboBox)
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_End)
    qtbot.keyClick(box, Qt.Key.Key_Return)
    assert workspace.preferences.text("theme") == "dark"
    assert workspace.look.is_dark


def test_a_folder_that_is_not_there_is_refused_in_a_sentence(screen, workspace, told, qtbot):
    line = row_of(screen, "log_folder").findChild(QLineEdit)
    qtbot.keyClicks(line, "/no/such/folder")
    qtbot.keyClick(line, Qt.Key.Key_Return)
    assert "/no/such/folder" in told[0].what and told[0].remedy
    assert workspace.preferences.text("log_folder") == ""


def test_searching_shows_what_matches_alone(screen, qtbot):
    field = screen.findChild(QLineEdit)
    qtbot.keyClicks(field, "dead band")
    seen = [row for row in screen.findChildren(PreferenceRow) if row.isVisible()]
    assert [row.preference.name for row in seen] == ["stick_dead_band"]
    field.setText("no such words")
    assert not any(row.isVisible() for row in screen.findChildren(PreferenceRow))
    field.clear()
    assert all(row.isVisibleTo(screen) for row in screen.findChildren(PreferenceRow))


def limit_of(screen, name):
    return next(row for row in screen._limits if row.name == name)


def test_a_limit_is_ordered_kept_and_ordered_again_for_the_same_vehicle(
    screen, workspace, live, canned, told, qtbot
):
    screen.begin(canned.views[0])
    box = limit_of(screen, "max_speed").findChild(QAbstractSpinBox)
    box.selectAll()
    qtbot.keyClicks(box, "3")
    qtbot.keyClick(box, Qt.Key.Key_Return)
    assert live.orders == [("max_speed", 3.0)]
    again = SettingsScreen(workspace)  # of the next start
    qtbot.addWidget(again)
    again.begin(canned.views[0])
    assert live.orders == [("max_speed", 3.0)] * 2
    assert "max_speed" in told[-1].what
    again.begin(canned.views[0])  # a reset: the limit holds, and nothing is told
    assert live.orders == [("max_speed", 3.0)] * 3 and len(told) == 1
    other = replace(canned.views[0], vehicle=replace(canned.views[0].vehicle, name="another"))
    again.begin(other)
    assert len(live.orders) == 3
    qtbot.wait(20)  # the last answers arrive


def test_a_limit_that_a_flight_has_not_is_greyed(screen, live, canned):
    values = {**canned.views[0].values}
    del values["warning_distance"]
    screen.begin(replace(canned.views[0], values=values))
    assert not limit_of(screen, "warning_distance").isEnabled()
    assert limit_of(screen, "max_speed").isEnabled()


def test_nonsense_that_was_kept_is_not_flown(screen, workspace, live, canned):
    vehicle = canned.views[0].vehicle.name
    for kept in ("nan", "text", "1e9"):
        workspace.preferences.store.setValue(f"limits/{vehicle}/max_speed", kept)
        screen.begin(canned.views[0])
    assert live.orders == []


def test_limits_are_rows_of_the_parameter_table():
    assert all(load_controller().table.find(name) for name in LIMIT_SETTINGS)


def test_nothing_begins_until_something_is_changed(screen, workspace, canned, qtbot, monkeypatch):
    begun = []
    monkeypatch.setattr(workspace.flight, "fly", lambda what, **options: begun.append(what))
    assert not screen._fly.isEnabled()
    screen.begin(canned.views[0])
    assert not screen._fly.isEnabled()
    screen._form._boxes["lidar"].click()
    screen._form._noise.click()
    assert screen._fly.isEnabled()
    qtbot.mouseClick(screen._fly, Qt.MouseButton.LeftButton)
    left = {"imu", "gps", "barometer", "range_finder", "magnetometer"}
    assert set(begun[0].sensors.use) == left
    assert begun[0].sensors.noise is False
    assert begun[0].world == "room"
    assert begun[0].script == canned.views[0].scenario.script
    kept = last_setup(workspace.preferences.store)
    assert not kept.exists()  # nobody knows yet whether it flies
    screen.begin(replace(canned.views[0], scenario=begun[0]))
    qtbot.waitUntil(kept.exists)
    workspace.errands.close()
    assert load_scenario(kept) == begun[0]


def test_an_estimator_is_chosen_for_the_next_flight(screen, workspace, canned, qtbot, monkeypatch):
    begun = []
    monkeypatch.setattr(workspace.flight, "fly", lambda what, **options: begun.append(what))
    screen.begin(canned.views[0])
    box = screen._form._estimator
    assert box.currentText() == "truth"
    box.setFocus()
    qtbot.keyClicks(box, "c")
    qtbot.keyClick(box, Qt.Key.Key_Return)
    box.activated.emit(box.currentIndex())
    qtbot.mouseClick(screen._fly, Qt.MouseButton.LeftButton)
    assert begun == [replace(canned.views[0].scenario, estimator="complementary")]
    own = replace(canned.views[0].scenario, estimator="/own/kalman.py")
    screen.begin(replace(canned.views[0], scenario=own))
    assert box.currentText() == "/own/kalman.py" and screen._form.scenario() == own


def test_a_period_stays_a_multiple_of_another_step(screen, canned):
    screen.begin(canned.views[0])
    step = screen._form._periods["physics_step"]
    step.setCurrentIndex(step.findData(1 / 256))
    screen._form._choose_period("")
    rates = screen._form.scenario().rates
    for period in (rates.physics_step, rates.control_period, rates.mode_period):
        assert (period * 256).is_integer()


def test_what_is_not_changed_stays_as_it_flies(screen, canned):
    sensors, rates = SensorsConfig(use=["all"], seed=3), Rates(control_period=1 / 64)
    scenario = replace(canned.views[0].scenario, world="room", sensors=sensors, rates=rates)
    screen.begin(replace(canned.views[0], scenario=scenario))
    assert not screen._fly.isEnabled()
    rates = replace(rates, record_period=1 / 64)
    assert screen._form.scenario() == replace(scenario, rates=rates)
    screen._form._boxes["lidar"].click()
    made = screen._form.scenario()
    kinds = {each.kind for each in canned.views[0].vehicle.sensors}
    assert set(made.sensors.use) == kinds - {"lidar"} and made.sensors.seed == 3
    assert scenario.sensors.use == ["all"]


def test_no_text_is_cut(screen):
    shown = [
        each
        for each in screen.findChildren(QWidget)
        if each.isVisible() and hasattr(each, "text") and each.text() and each.width() > 0
    ]
    lines = [each for each in shown if not getattr(each, "wordWrap", lambda: False)()]
    assert len(lines) > 100
    for each in lines:
        assert each.sizeHint().width() <= max(each.width(), each.minimumWidth()), each.text()
