"""An excitation in the real window, by mouse and keyboard: refused, flown, and ended by itself."""

import pytest
from PyQt6.QtCore import QSettings, Qt

from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.workspace import make_workspace
from workbench.live.choice import Choice
from workbench.live.orders import SetSpeed
from workbench.scenario.scenario import Action

LIMIT = 120_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(qapp, qtbot, tmp_path):
    """A drone that hovers 3 m before a wall."""
    world = tmp_path / "walled.yaml"
    world.write_text(
        "title: A wall\nobstacles:\n"
        "  - {name: wall, shape: {box: [0.2, 20, 6]}, position: [3.1, 0, 3]}\n"
    )
    store = QSettings(str(tmp_path / "kept.ini"), QSettings.Format.IniFormat)
    made = MainWindow(make_workspace(Preferences(store)), first="tuning", view3d=False)
    qtbot.addWidget(made)
    made.control.fly(Choice("hover", world=str(world)))
    made.show()
    qtbot.waitUntil(lambda: made.stack.name == "tuning", timeout=LIMIT)
    yield made
    made.close()


def test_it_is_refused_before_a_wall_returns_and_ends_when_the_drone_swings(window, qtbot):
    flight, card = window.workspace.flight, window.stack.current.excitation
    told = []
    window.workspace.notices.told.connect(lambda notice: told.append(notice.what))

    def enter(amplitude):
        card.amplitude.setFocus()
        card.amplitude.selectAll()
        qtbot.keyClicks(card.amplitude, amplitude)
        qtbot.keyClick(card.amplitude, Qt.Key.Key_Return)

    qtbot.waitUntil(card.button.isEnabled, timeout=LIMIT)
    enter("2")
    qtbot.mouseClick(card.button, LEFT)
    qtbot.waitUntil(lambda: any("there is no room" in each for each in told), timeout=LIMIT)
    assert "wall is 2." in told[-1]
    assert not card.is_running

    enter("-1")
    qtbot.mouseClick(card.button, LEFT)
    qtbot.waitUntil(lambda: card.is_running, timeout=LIMIT)
    flight.do(SetSpeed(10.0))
    back = "Flying back to where it began."
    qtbot.waitUntil(lambda: card.said.text() == back, timeout=LIMIT)
    qtbot.waitUntil(lambda: flight.view.exciting.round > 1, timeout=LIMIT)
    assert abs(flight.view.snapshot.p_WB[0]) < 2.5

    flight.do(Action(set={"kp_velocity_x": 18.0}))
    qtbot.waitUntil(lambda: not card.is_running, timeout=LIMIT)
    assert "the drone oscillates" in card.said.text()
    assert "The excitation has ended: the drone oscillates" in told[-1]
