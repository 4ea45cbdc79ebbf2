"""The Visualization screen of a flight that has begun."""

import pytest

from workbench.gui.visualization.visualization_screen import VisualizationScreen


@pytest.fixture
def begun(workspace, canned, qtbot):
    made = VisualizationScreen(workspace)
    qtbot.addWidget(made)
    made.resize(1190, 600)
    made.show()
    qtbot.waitExposed(made)
    workspace.signals.begin(canned.views[0].topics)
    made.begin(canned.views[0])
    yield made
    made.close_screen()
