"""What every screen of the app is."""

from collections.abc import Callable

from PyQt6.QtWidgets import QWidget

from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class Screen(QWidget):
    """A page of the app behind one button of the side bar.

    Attributes:
        title: in the side bar and as accessible name.
        icon: name of its picture, see `icons`.
    """

    title = ""
    icon = ""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.workspace = workspace
        self.setAccessibleName(f"{self.title} screen")

    def begin(self, view: LiveView) -> None:
        """Take note that a flight has begun: vehicle, topics and scenario are known."""

    def take_over(self, view: LiveView) -> None:
        """Take note that another controller has taken over in flight."""

    def show_view(self, view: LiveView) -> None:
        """Show the present; called at most sixty times a second, and only while it is seen."""

    def unsaved(self) -> str:
        """Return what would be lost with the flight, as a sentence; "" for nothing."""
        return ""

    def save_unsaved(self, saved: Callable[[], object]) -> None:
        """Let the user save that, and call back once it is saved."""

    def release(self) -> None:
        """Let go of what is held: the screen is left, or the window has lost focus."""

    def close_screen(self) -> None:
        """End what the screen has started; the app closes."""
