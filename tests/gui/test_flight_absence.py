"""What screens show in place of a flight: nothing was opened, or it starts, and for how long."""

import dataclasses

from workbench.gui.flight_absence import NOTHING_FLIES_TEXT, FlightAbsence
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.home.home_screen import HomeScreen
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.gui.visualization.chart_pane import ChartPane
from workbench.gui.visualization.layouts import ChartSpec
from workbench.live.view import LiveView


def test_while_a_flight_starts_all_screens_say_so_and_for_how_long(workspace, qtbot, canned):
    flight, time = workspace.flight, [100.0]
    absence = FlightAbsence(flight, workspace.preferences.store, lambda: time[0])
    workspace = dataclasses.replace(workspace, absence=absence)
    editor = GainEditor(flight, workspace.analysis, workspace.preferences, workspace.notices)
    panel = GainPanel(workspace, editor)
    card, home = ExcitationCard(workspace), HomeScreen(workspace)
    pane = ChartPane(workspace, ChartSpec("", ()), workspace.signals)
    for widget in (panel, card, home, pane):
        qtbot.addWidget(widget)
    condition = home.cards["condition"]

    def said():
        return {
            panel.nothing.text(),
            card.said.text(),
            condition.spoken.removeprefix(", "),
            pane.chart._model.hint,
        }

    assert said() == {NOTHING_FLIES_TEXT}
    flight._live = object()
    flight.viewed.emit(LiveView(said="loading Drake"))
    assert said() == {"Starting: loading Drake."}
    late = HomeScreen(workspace)
    qtbot.addWidget(late)
    assert late.cards["condition"].spoken.endswith("Starting: loading Drake.")
    time[0] += 7.2
    flight.viewed.emit(canned.views[-1])
    assert absence.text == ""
    flight.viewed.emit(LiveView(said="loading Drake"))
    assert said() == {"Starting, about 7\N{NO-BREAK SPACE}s: loading Drake."}
    flight.viewed.emit(LiveView().ended("the drone has no rotors"))
    flight._live = None
    assert said() == {NOTHING_FLIES_TEXT}
