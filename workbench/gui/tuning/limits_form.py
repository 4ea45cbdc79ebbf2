"""Fields for limits, shown when they are wanted."""

from collections.abc import Sequence

from PyQt6.QtWidgets import QGridLayout, QToolButton, QWidget

from workbench.gui.number_field import NumberField, buddy
from workbench.gui.tuning.limit_table import Limit
from workbench.gui.tuning.limits import Limits
from workbench.gui.units import Unit

BARE = "QAbstractSpinBox { padding-right: 5px; } QAbstractSpinBox:focus { padding-right: 4px; }"
"""A field without arrows needs no room for them; arrow keys step it."""
NARROWEST = 72
"""Of a field [px]."""


class LimitsForm(QWidget):
    """A field for each of some limits.

    Args:
        rows: of the table of limits.
        limits: their values.
        columns: of fields.

    Attributes:
        fields: by the limit's name.
        button: shows and hides the form.
    """

    def __init__(self, rows: Sequence[Limit], limits: Limits, columns: int = 2) -> None:
        super().__init__()
        self.fields: dict[str, NumberField] = {}
        self._limits = limits
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        for index, row in enumerate(rows):
            field = NumberField(f"Limit of {row.label.lower()}", row.decimals, 10.0**-row.decimals)
            field.set_range(Unit(row.unit), row.minimum, row.maximum)
            field.show_si(limits.value(row.name))
            field.edited.connect(lambda value, name=row.name: limits.set(name, value))
            field.setMinimumWidth(NARROWEST)
            field.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
            field.setProperty("class", "bare")
            field.setStyleSheet(BARE)
            label = buddy(f"{row.short.capitalize()} {row.sign}", field)
            label.setToolTip(f"{row.label}: {row.help}")
            line, column = divmod(index, columns)
            grid.addWidget(label, line, 2 * column)
            grid.addWidget(field, line, 2 * column + 1)
            self.fields[row.name] = field
        for column in range(columns):
            grid.setColumnStretch(2 * column + 1, 1)
        self.setVisible(False)
        self.button = QToolButton()
        self.button.setText("Limits")
        self.button.setCheckable(True)
        self.button.setProperty("class", "quiet compact")
        self.button.setAccessibleName("Show the limits, to set others")
        self.button.toggled.connect(self.setVisible)
        limits.changed.connect(self._show)

    def _show(self, name: str) -> None:
        if name in self.fields:
            self.fields[name].show_si(self._limits.value(name))
