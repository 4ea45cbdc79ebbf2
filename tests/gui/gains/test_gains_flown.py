"""A slider that moves gains of a real flight, and what the drone then does."""

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtTest import QTest

from tests.drawn_ways import GAIN, drawn_parts, present_way
from workbench.analysis.queries import FindRanges
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_panel import GainPanel
from workbench.ipc.send_queue import SendQueue
from workbench.live.choice import Choice
from workbench.live.orders import FlightOrder, GetParameter
from workbench.scenario.scenario import Action, Gust, Scenario

NAME = "kp_velocity_x"
SECONDS = 60000


@pytest.fixture
def flown(workspace, qtbot):
    """A hover, with the gains' form beside it; every gain is known to be stable."""
    editor = GainEditor(
        workspace.flight, workspace.analysis, workspace.preferences, workspace.notices
    )
    panel = GainPanel(workspace, editor)
    qtbot.addWidget(panel)
    panel.resize(420, 640)
    workspace.flight.begun.connect(editor.begin)
    workspace.flight.fly(Choice("hover"), draw=False)
    qtbot.waitUntil(lambda: NAME in panel.rows, timeout=SECONDS)
    panel.show()
    every = {row.name: (row.minimum, row.maximum) for row in editor.rows}
    workspace.analysis.tell(FindRanges(dict(editor.flown)), every)
    return editor, panel


def fastest(workspace, qtbot, velocity):
    """Ask for a level speed from rest and return the largest acceleration along x [m/s²]."""
    begun = workspace.signals.now
    workspace.flight.do(Action(velocity=[velocity, 0.0, 0.0]))
    qtbot.waitUntil(lambda: workspace.signals.now > begun + 0.8, timeout=SECONDS)
    _, values = workspace.signals.series("acceleration_data.vdot_x", begun)
    peak = float(values.max())
    workspace.flight.do(Action(velocity=[0.0, 0.0, 0.0]))
    return peak


def test_a_slider_changes_what_flies_until_it_is_reverted_or_reset(
    flown, workspace, qtbot, monkeypatch
):
    """The gain goes the way that docs/architecture.md draws; tests/docs has the flight's part."""
    editor, panel = flown
    asked, ways, post = [], [], SendQueue.post

    def noted(queue, message):
        if isinstance(message.what, Action) and message.what.set:
            ways.append(present_way())
        post(queue, message)

    monkeypatch.setattr(SendQueue, "post", noted)
    before = fastest(workspace, qtbot, 1.0)
    begun = workspace.signals.now
    qtbot.waitUntil(lambda: workspace.signals.now > begun + 2.5, timeout=SECONDS)  # it is at rest
    slider = panel.rows[NAME].slider
    start = editor.flown[NAME]
    x = round(slider._x(slider._place))
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=QPoint(x, 12))
    QTest.mouseMove(slider, QPoint(x - 10, 12))
    QTest.mouseMove(slider, QPoint(x - 20, 12))
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=QPoint(x - 20, 12))
    wanted = editor.proposed[NAME]
    assert wanted < 0.75 * start
    assert ways[0] == drawn_parts(GAIN)[0][:-1]
    qtbot.waitUntil(lambda: editor.flown[NAME] == wanted, timeout=SECONDS)
    workspace.flight.do(GetParameter(NAME), done=asked.append)
    qtbot.waitUntil(lambda: asked == [wanted], timeout=SECONDS)
    after = fastest(workspace, qtbot, 1.0)
    assert after < 0.9 * before
    editor.revert()
    workspace.flight.do(GetParameter(NAME), done=asked.append)
    qtbot.waitUntil(lambda: asked == [wanted, start], timeout=SECONDS)
    assert editor.summary() == "kept"
    editor.propose(NAME, 2.0)
    editor.keep()
    qtbot.waitUntil(lambda: editor.flown[NAME] == 2.0, timeout=SECONDS)
    workspace.flight.do(FlightOrder.RESET)
    qtbot.waitUntil(lambda: editor.flown[NAME] == start, timeout=SECONDS)
    qtbot.waitUntil(lambda: panel.rows[NAME].field.value() == start, timeout=SECONDS)
    assert editor.kept[NAME] == 2.0
    assert editor.summary() == "1 gain not kept"


def test_what_the_script_of_a_flight_changes_is_followed(workspace, qtbot):
    editor = GainEditor(
        workspace.flight, workspace.analysis, workspace.preferences, workspace.notices
    )
    workspace.flight.begun.connect(editor.begin)
    script = [Action(at=0.3, set={NAME: 2.5}), Action(at=0.4, gust=Gust([1.5, 0.0, 0.0], 2.0))]
    workspace.flight.fly(Scenario(script=script), draw=False)
    qtbot.waitUntil(lambda: editor.flown.get(NAME) == 2.5, timeout=SECONDS)
    qtbot.waitUntil(lambda: editor.flown["gust_x"] == 1.5, timeout=SECONDS)
    qtbot.waitUntil(lambda: editor.flown["gust_duration"] == 2.0, timeout=SECONDS)
    assert editor.proposed[NAME] == 2.5
