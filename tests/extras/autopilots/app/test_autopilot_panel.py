"""The form with the gains of a firmware."""

import re

import pytest

from workbench.control.controller_file import load_controller
from workbench.gui.gains.gain_panel import GainPanel
from workbench.live.view import LiveView


@pytest.fixture
def panel(rig, workspace, qtbot):
    made = GainPanel(workspace, rig.editor)
    qtbot.addWidget(made)
    made.resize(380, 600)
    made.show()
    qtbot.waitExposed(made)
    return made


def test_a_firmwares_gains_have_its_own_names_and_none_is_cut(rig, panel, qtbot, case):
    panel.resize(440, 600)  # as in a window of 1400 pixels
    for name, known, file_name in (
        ("px4", "MPC_Z_VEL_MAX_DN", "MPC_Z_VEL_MAX_DN"),
        ("ardupilot", "ATC_RAT_RLL_FLTD", "ATC_RAT_RLL_FLTD"),
        ("betaflight", "dterm_lpf1_dyn_min_hz", "dterm_lpf1_dyn_min_hz"),
        ("crazyflie", "pid_attitude_roll_kp", "pid_attitude.roll_kp"),
    ):
        with case(name):
            law = load_controller(name)
            values = law.table.defaults()
            rig.editor.begin(LiveView(values=values, vehicle=object(), controller=law))
            qtbot.waitUntil(lambda known=known: known in panel.rows)
            assert rig.editor.words(known) == file_name
            assert panel.rows[known]._name.text() == file_name
            shown = [row for row in panel.rows.values() if row.isVisible()]
            assert len(shown) > 10
            names = [row._name for row in shown]  # one that wraps asks for its height
            qtbot.waitUntil(
                lambda n=names: all(e.height() >= e.heightForWidth(e.width()) for e in n)
            )
            for row in shown:
                unit = row._unit_shown
                text = re.sub("<[^>]*>", "", unit.text())
                assert unit.width() >= unit.fontMetrics().horizontalAdvance(text), text
