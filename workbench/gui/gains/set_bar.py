"""The line above the gains that shows and selects a set of scheduled gains."""

from PyQt6.QtWidgets import QComboBox, QWidget

from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.layout import choice, hbox, label
from workbench.session.snapshot import Snapshot


class SetBar(QWidget):
    """Shows which set of scheduled gains flies, and selects the one whose sliders are shown.

    Args:
        editor: has the gains.
    """

    def __init__(self, editor: GainEditor) -> None:
        super().__init__()
        self._editor = editor
        self.choice = choice(
            "Set of gains",
            help="The sliders show, and margins and steps are for, this set of gains in hover; the "
            "flight continues between the sets",
        )
        self.choice.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        name = label("&Set")
        name.setBuddy(self.choice)
        self.flies = label(kind="muted")
        hbox(name, self.choice, (self.flies, 1), of=self, margins=(8, 0, 8, 0))
        self.choice.activated.connect(lambda place: editor.show_set(place - 1 if place else None))
        self.show_schedule()

    def show_schedule(self) -> None:
        """Show the sets of the flight's gains; hidden without a schedule."""
        schedule = self._editor.schedule
        self.setVisible(schedule is not None)
        self.choice.clear()
        if schedule is not None:
            self.choice.addItem("that flies")
            numbers = range(len(schedule.values))
            self.choice.addItems([schedule.where(number) for number in numbers])
        self.flies.setText("")

    def show_snapshot(self, snapshot: Snapshot) -> None:
        """Show which set flies now."""
        schedule, shown = self._editor.schedule, self._editor.shown_set
        if schedule is None or shown is None:
            return
        value = self._editor.scheduled_value(snapshot)
        unit = "" if schedule.quantity.unit == "1" else f" {schedule.quantity.unit}"
        shows = f", set at {schedule.values[shown]:g}" if self._editor.follows else ""
        self.flies.setText(f"{schedule.quantity.name} {value:.2f}{unit}{shows}")
