"""The Home screen with a clock that a test moves."""

import pytest

from workbench.gui.home.home_screen import HomeScreen


class Clock:
    """A clock that stands until it is moved."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def home(qtbot, workspace, clock):
    """The screen before a flight."""
    made = HomeScreen(workspace, clock=clock)
    qtbot.addWidget(made)
    made.resize(1190, 600)
    return made


@pytest.fixture
def flown(home, workspace, canned, clock):
    """The screen after the last second of the flight, shown as the main window does."""
    workspace.signals.begin(canned.views[0].topics)
    home.begin(canned.views[0])
    for view, published in zip(canned.views[-60:], canned.published[-60:], strict=True):
        workspace.flight.streamed.emit(list(published))
        home.show_view(view)
        clock.now += 1 / 60
    clock.now += 1.0
    home.show_view(canned.views[-1])
    return home
