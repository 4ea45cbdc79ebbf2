"""A card with the name of the opened log."""

from PyQt6.QtWidgets import QLabel

from workbench.gui.help import add_card_help
from workbench.gui.tuning.added_cards import AddedCard, CardRow

add_card_help(
    "Log name", "The name of the opened log.", "Open another log to see its name.", "app.md#tuning"
)


class LogNameCard(AddedCard):
    """Shows the name of the opened log."""

    def __init__(self, workspace, trial, designs):
        super().__init__("Log name")
        self.name = QLabel()
        self.body.addWidget(self.name)
        workspace.log.changed.connect(lambda: self.name.setText(workspace.log.path.name))


CARD = CardRow("Log name", LogNameCard, log_button="&Name…", log_help="Show its name")
