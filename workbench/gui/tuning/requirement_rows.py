"""The wishes of a search as rows: metric, relation, number and unit."""

from collections.abc import Sequence

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.quantity import DisplayUnit
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.design.metrics import WISHED_METRICS, Metric, find_metric, units_of_bounds
from workbench.design.tune.wish import groups_of, parse_wish, subjects_of
from workbench.gui.layout import NO_MARGINS, button, choice, hbox, label, tool_button, vbox
from workbench.gui.number_field import NumberField
from workbench.gui.tuning.card import CARD_SPACING_PX, set_items, wrapped_label
from workbench.gui.tuning.wind_form import ELIDING_SIZE_POLICY

MAX_REQUIREMENTS = 6
"""Largest number of wishes."""
MAX_BOUND = 1e9
"""Every number is accepted, so that the metric can say what is wrong with it."""
MIN_METRIC_CHARACTERS = 10
"""Least width of the box of metrics; its list is as wide as its texts."""
BOUND_WIDTH_DIGITS = 8
RELATIONS = {"<=": "≤", ">=": "≥"}
NEW_REQUIREMENT = "level.settling_time <= 1 s"


def requirement_names(law: Controller) -> dict[str, str]:
    """Return the numbers that a wish can bound for a controller, in words, by their names."""
    return {
        f"{subject}.{metric.name}": f"{subject} {metric.name}".replace("_", " ")
        for metric in WISHED_METRICS
        for subject in (*groups_of(metric, law), *subjects_of(metric, law))
    }


class RequirementRow(QWidget):
    """One wish, with its error below.

    Args:
        wish: the wish, as `x.rise_time <= 0.4 s`.
        law: the controller whose loops it may name.

    Attributes:
        name: box of the bounded number.
        relation: box of the relation.
        number: field of the bound.
        unit: box of its unit.
        remove: removes the row.
        fault: what is wrong.
    """

    changed = pyqtSignal()
    """The wish changed."""

    def __init__(self, wish: str, law: Controller) -> None:
        super().__init__()
        self._law = law
        self.name, self.relation, self.unit = choice("Metric"), choice("Relation"), choice("Unit")
        self.name.setSizeAdjustPolicy(ELIDING_SIZE_POLICY)
        self.name.setMinimumContentsLength(MIN_METRIC_CHARACTERS)
        units = (unit for metric in WISHED_METRICS for unit in units_of_bounds(metric))
        self.unit.setMinimumContentsLength(max(map(len, units)))  # as wide in all rows
        self.number = NumberField("Bound", 3, 0.1)
        self.number.set_range(DisplayUnit(""), -MAX_BOUND, MAX_BOUND)
        digit = self.fontMetrics().horizontalAdvance("0")
        self.number.setFixedWidth(BOUND_WIDTH_DIGITS * digit)
        self.number.setButtonSymbols(NumberField.ButtonSymbols.NoButtons)
        self.remove = tool_button("✕", kind="quiet compact", help="Remove this wish")
        self.remove.setAccessibleName("Remove this wish")
        self.fault = wrapped_label("bad")
        self.fault.hide()
        set_items(self.relation, RELATIONS)
        parts = ((self.name, 1), self.relation, self.number, self.unit, self.remove)
        row = hbox(*parts, spacing=CARD_SPACING_PX - 2)
        vbox(row, self.fault, of=self, margins=NO_MARGINS, spacing=1)
        self._show(wish)
        self.name.activated.connect(self._choose_metric)
        self.relation.activated.connect(lambda _: self._check())
        self.number.edited.connect(lambda _: self._check())
        self.number.refused.connect(lambda _: self.changed.emit())
        self.unit.activated.connect(lambda _: self._check())  # the number stays as typed

    @property
    def text(self) -> str:
        """The wish as the search takes it."""
        number = f"{self.number.value():.6g} {self._unit}".strip()
        return f"{self.name.currentData()} {self.relation.currentData()} {number}"

    @property
    def is_good(self) -> bool:
        """Whether no error is known."""
        return not self.number.fault and not self._error()

    def set_controller(self, law: Controller) -> None:
        """Offer the loops of a controller; a loop that it lacks stays, and is marked."""
        self._law = law
        self._offer(self.name.currentData())
        self.blame(self._error())

    def blame(self, said: str) -> None:
        """Show an error, "" for none."""
        self.fault.setText(f"✕ {said}" if said else "")
        self.fault.setVisible(bool(said))
        self.number.setAccessibleDescription(said)

    @property
    def _metric(self) -> Metric:
        return find_metric(str(self.name.currentData()).partition(".")[2], WISHED_METRICS)

    @property
    def _unit(self) -> str:
        return str(self.unit.currentData() or "")

    def _show(self, wish: str) -> None:
        name, relation, number, *unit = wish.split()
        self._offer(name)
        self.relation.setCurrentIndex(self.relation.findData(relation))
        self._offer_units()
        self.unit.setCurrentIndex(max(0, self.unit.findData(" ".join(unit))))
        self.number.show_si(float(number))

    def _offer(self, name: str) -> None:
        """Offer all metrics of the controller, and a name that it may lack."""
        names = requirement_names(self._law)
        names.setdefault(name, name.replace(".", " ").replace("_", " "))
        set_items(self.name, names, name)

    def _offer_units(self) -> None:
        set_items(self.unit, {each: each or "×" for each in units_of_bounds(self._metric)})

    def _choose_metric(self, _: int) -> None:
        """Offer the units and the usual relation of another metric."""
        self._offer_units()
        relation = ">=" if self._metric.better > 0 else "<="
        self.relation.setCurrentIndex(self.relation.findData(relation))
        self._check()

    def _error(self) -> str:
        """Return what is wrong with the wish, as a sentence; "" if it is valid."""
        try:
            parse_wish(self.text, law=self._law)
        except WorkbenchError as error:
            return str(error)
        return ""

    def _check(self) -> None:
        self.blame(self._error())
        self.changed.emit()


class RequirementRows(QWidget):
    """Wishes one below the other, and a button for another one.

    Args:
        wishes: initial wishes.

    Attributes:
        rows: a row for each wish.
        add: adds one.
    """

    changed = pyqtSignal()
    """The wishes changed."""

    def __init__(self, wishes: Sequence[str]) -> None:
        super().__init__()
        self._law = load_controller()
        self.rows: list[RequirementRow] = []
        self.add = button("Add &wish", lambda: self._add(NEW_REQUIREMENT), "quiet compact")
        heading = hbox((label("Wishes", "muted"), 1), self.add)
        self._box = vbox(heading, of=self, margins=NO_MARGINS, spacing=3)
        for wish in wishes:
            self._add(wish)

    @property
    def wishes(self) -> tuple[str, ...]:
        """The wishes."""
        return tuple(row.text for row in self.rows)

    @property
    def are_good(self) -> bool:
        """Whether there is a wish, and all are valid."""
        return bool(self.rows) and all(row.is_good for row in self.rows)

    def set_controller(self, law: Controller) -> None:
        """Accept wishes about the loops of a controller; mark those with unknown loops."""
        self._law = law
        for row in self.rows:
            row.set_controller(law)

    def _add(self, wish: str) -> None:
        row = RequirementRow(wish, self._law)
        row.changed.connect(self.changed)
        row.remove.clicked.connect(lambda: self._remove(row))
        self.rows.append(row)
        self._box.addWidget(row)
        self._show_count()

    def _remove(self, row: RequirementRow) -> None:
        self.rows.remove(row)
        self._box.removeWidget(row)
        row.hide()
        row.deleteLater()
        self._show_count()

    def _show_count(self) -> None:
        self.add.setEnabled(len(self.rows) < MAX_REQUIREMENTS)
        self.changed.emit()
