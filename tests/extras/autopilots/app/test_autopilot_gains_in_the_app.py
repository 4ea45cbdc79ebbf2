"""Gains from an autopilot's file and into it, on the Tuning screen, with margins beside them."""

import dataclasses

import numpy as np
import pytest

from workbench.analysis.queries import Judge
from workbench.control.controller_file import load_controller
from workbench.gui.gains.gain_bar import GainBar
from workbench.gui.tuning.tuning_screen import TuningScreen

PARAMS = "# mine\r\n1\t1\tBAT1_N_CELLS\t4\t6\r\n1\t1\tMC_ROLLRATE_P\t{}\t9\r\n"


@pytest.fixture
def px4(flying):
    """The view of a drone that flies PX4's law with its defaults."""
    law = load_controller("px4")
    values = {row.name: row.default for row in law.table}
    scenario = dataclasses.replace(flying.scenario, controller="px4")
    return dataclasses.replace(flying, controller=law, values=values, scenario=scenario)


@pytest.fixture
def screen(offline, px4, qtbot):
    offline.preferences.set("apply_gains", "on Enter")
    offline.flight.show(px4)
    made = TuningScreen(offline)
    qtbot.addWidget(made)
    made.resize(1190, 700)
    made.begin(px4)
    made.show()
    yield made
    made.close_screen()


@pytest.fixture
def bar(screen):
    return screen.findChild(GainBar)


def test_an_import_shows_what_it_does_to_margins_before_anything_flies(
    screen, bar, judge, make_loop, tmp_path, qtbot
):
    path = tmp_path / "mine.params"
    path.write_bytes(PARAMS.format("0.12").encode())
    with qtbot.waitSignal(screen.gain_files.diff_changed):
        screen.gain_files.load_autopilot(path)
    (tick,) = bar.diff.ticks.values()
    assert tick.text() == "MC_ROLLRATE_P"
    assert bar.diff.ticks["MC_ROLLRATE_P"].accessibleName().endswith("0.15 becomes 0.12 s/rad")
    assert "px4 1.17" in bar.diff.said.text()
    assert screen.diff_margins.isVisible()
    analysis, flown = screen.workspace.analysis, screen.gains.flown
    analysis.tell(*judge({**flown, "MC_ROLLRATE_P": 0.12}))
    weak = make_loop("roll", phase_margin=np.radians(21.0))
    analysis.tell(*judge(flown, weak))
    asked = [question.gains["MC_ROLLRATE_P"] for question in analysis.of(Judge)]
    assert {0.12, 0.15} <= set(asked)
    assert screen.diff_judgement.gains["MC_ROLLRATE_P"] == 0.12
    assert screen.diff_judgement.flown.loops[3].phase_margin == pytest.approx(np.radians(21.0))
    bar.diff.fly.click()
    assert not screen.diff_margins.isVisible()
    assert screen.gains.proposed["MC_ROLLRATE_P"] == 0.12


def test_what_is_unsafe_is_left_out_and_named(screen, bar, tmp_path, qtbot):
    path = tmp_path / "mine.params"
    path.write_text(PARAMS.format("nan") + "1\t1\tMC_PITCHRATE_P\t0.12\t9\n")
    with qtbot.waitSignal(screen.gain_files.diff_changed):
        screen.gain_files.load_autopilot(path)
    assert list(bar.diff.ticks) == ["MC_PITCHRATE_P"]
    assert "MC_ROLLRATE_P is not a number and is left out" in bar.diff.said.text()


def test_an_export_changes_what_is_ticked_and_nothing_else(screen, bar, tmp_path, qtbot):
    path = tmp_path / "mine.params"
    more = "1\t1\tMC_PITCHRATE_P\t0.2\t9\r\n"
    path.write_bytes((PARAMS.format("0.12") + more).encode())
    with qtbot.waitSignal(screen.gain_files.diff_changed):
        screen.gain_files.export(path)
    assert list(bar.diff.ticks) == ["MC_ROLLRATE_P", "MC_PITCHRATE_P"]
    offered = dict(screen.gain_files.diff.values)
    screen.gains._flown.values["MC_ROLL_P"] = 9.0  # a client's, meanwhile
    assert screen.gain_files.diff.values == offered
    assert bar.diff.fly.text() == "&Write 2 ticked"
    bar.diff.ticks["MC_PITCHRATE_P"].setChecked(False)
    bar.diff.fly.click()
    expected = (PARAMS.format("0.150000005960464478") + more).encode()
    qtbot.waitUntil(lambda: path.read_bytes() == expected, timeout=20000)


@pytest.mark.parametrize("present", [True, False])
def test_an_export_that_would_not_fly_is_written_only_if_the_user_insists(
    screen, bar, tmp_path, qtbot, present
):
    """With the sentence of `workbench gains export`; other ticks are another question."""
    told = []
    screen.workspace.notices.told.connect(told.append)
    path = tmp_path / "mine.params"
    before = (PARAMS.format("0.12") + "1\t1\tMC_YAW_P\t2.5\t9\r\n").encode()
    if present:
        path.write_bytes(before)
    flown = {"MC_YAW_P": 0.0, "MC_ROLLRATE_P": 0.14}
    screen.gains._flown.values |= flown
    with qtbot.waitSignal(screen.gain_files.diff_changed):
        screen.gain_files.export(path)
    assert bar.diff.ticks.keys() == flown.keys()
    bar.diff.fly.click()
    qtbot.waitUntil(lambda: bool(told), timeout=20000)
    said = "mine.params: would not fly: MC_YAW_P is 0: nothing corrects the heading; nothing is"
    assert said in told[-1].what
    assert (path.read_bytes() if path.exists() else None) == (before if present else None)
    assert bar.diff.fly.text() == "&Write 2 anyway"
    bar.diff.ticks["MC_ROLLRATE_P"].setChecked(False)
    assert bar.diff.fly.text() == "&Write 1 ticked"
    del told[:]
    bar.diff.fly.click()
    qtbot.waitUntil(lambda: bool(told), timeout=20000)
    assert not bar.diff.ticks["MC_ROLLRATE_P"].isChecked()
    assert bar.diff.fly.text() == "&Write 1 anyway"
    bar.diff.fly.click()
    qtbot.waitUntil(lambda: path.exists() and b"MC_YAW_P\t0\t9" in path.read_bytes(), timeout=20000)
    assert (b"MC_ROLLRATE_P\t0.12\t9" in path.read_bytes()) is present


def test_a_file_of_another_firmware_is_refused(screen, tmp_path, qtbot):
    told = []
    screen.workspace.notices.told.connect(told.append)
    path = tmp_path / "mine.param"
    path.write_text("ATC_ANG_RLL_P,4.5\n")
    screen.gain_files.load_autopilot(path)
    qtbot.waitUntil(lambda: bool(told), timeout=20000)
    assert "choose File > Controller > ardupilot first" in told[-1].what
