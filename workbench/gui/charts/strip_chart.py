"""A chart that follows a flight: the last seconds of some signals."""

from PyQt6.QtCore import QEvent, QPoint, Qt
from PyQt6.QtGui import QAction, QContextMenuEvent, QFocusEvent, QKeyEvent
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.chart_keys import key_of, obey
from workbench.gui.charts.chart_menu import make_menu
from workbench.gui.charts.copies import Copies
from workbench.gui.charts.curve import Curve, Source
from workbench.gui.charts.curve_style import CurveStyle
from workbench.gui.charts.moving_chart import MovingChart
from workbench.gui.workspace import Workspace


class StripChart(MovingChart):
    """Draws the last seconds of its curves whenever `refresh` is called.

    Wheel: time; with Ctrl, or over an axis: values. Drag: zoom to a box. Double click, or Escape:
    follow again. Space: pause the picture. Arrows: cursor. Page up and down: move. A, B: cursors
    that stay. S: statistics. Z: always show zero. +, -: zoom. Ctrl+C: copy the data.

    Args:
        workspace: colours, units and preferences.
        parent: whose life it shares.

    Attributes:
        extra_actions: of the menu, besides the chart's own.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        self._copies = Copies(workspace, self)
        self.extra_actions: list[QAction] = []
        self.head.legend.toggled.connect(self.toggle_curve)
        self.head.menu_wanted.connect(self._open_menu)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self._describe()

    def add_curve(
        self,
        label: str,
        unit: str,
        source: Source,
        *,
        colour: int | None = None,
        style: CurveStyle = CurveStyle.SOLID,
    ) -> Curve:
        """Draw another signal; curves of a unit share an axis.

        Args:
            label: in the legend.
            unit: SI, as topics have it.
            source: returns times [s] and values from a time on [s].
            colour: its number, `COMMAND` for that of commands, None for the first that is free.
            style: of its stroke.

        Raises:
            WorkbenchError: if there is no room for another curve or unit.
        """
        curve = self._picture.curves.add(label, unit, source, colour, style)
        if self.is_paused:
            curve.freeze()
        self._curves_changed()
        return curve

    def remove_curve(self, curve: Curve) -> None:
        """Draw a curve no more."""
        self._picture.curves.remove(curve)
        self._curves_changed()

    @property
    def curves(self) -> tuple[Curve, ...]:
        """What is drawn."""
        return tuple(self._picture.curves)

    def toggle_curve(self, index: int) -> None:
        """Hide a curve, or show it again."""
        curve = self._picture.curves[index]
        curve.visible = not curve.visible
        self._picture.window.forget_ranges()
        self.redraw()

    def add_limit(self, value: float, label: str, unit: str | None = None) -> None:
        """Draw a line across at a value in SI, on the axis of a unit, the first one's if None."""
        self._picture.limits.append((value, label, unit))

    def clear_limits(self) -> None:
        """Draw no lines across."""
        self._picture.limits.clear()

    def set_title(self, title: str) -> None:
        """Give the chart a name."""
        self.head.set_title(title)
        self._describe()

    @property
    def title(self) -> str:
        """Its name."""
        return self.head.title

    def copy_picture(self) -> None:
        """Copy the chart as a picture."""
        self._copies.copy_picture(self)

    def copy_data(self) -> None:
        """Copy the samples that are seen, in SI, with tabs between."""
        self._copies.copy_data(self._picture.columns())

    def save_picture(self) -> None:
        """Write the chart as a picture (PNG) to the folder for logs."""
        self._copies.save_picture(self, self.title)

    def save_data(self) -> None:
        """Write the samples that are seen (CSV), in SI, to the folder for logs."""
        self._copies.save_data(self._picture.columns(), self.title)

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Offer what can be done."""
        if event is not None:
            make_menu(self).popup(event.globalPos())

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Obey the keyboard."""
        key = key_of(event) if event is not None else None
        if key is None:
            super().keyPressEvent(event)
        else:
            obey(self, key)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show that keys go here."""
        self.canvas.set_focus_shown(True)

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Keys go elsewhere."""
        self.canvas.set_focus_shown(False)

    def changeEvent(self, event: QEvent | None) -> None:
        """Follow another font."""
        if event is not None and event.type() == QEvent.Type.FontChange:
            self.head.legend.forget_widths()
        super().changeEvent(event)

    def _curves_changed(self) -> None:
        self._picture.window.forget_ranges()
        self.head.legend.forget_widths()
        self._describe()
        self._soon.start()
        self.picture_changed.emit()

    def _describe(self) -> None:
        labels = ", ".join(curve.label for curve in self.curves) or "no signals"
        self.setAccessibleName(f"Chart {self.title}".strip())
        self.setAccessibleDescription(f"{labels}, over time in s")

    def _open_menu(self, place: QPoint) -> None:
        make_menu(self).popup(place)
