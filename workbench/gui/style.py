"""The app's style sheet and palette, made from the colours of `Look`.

The property `class` states the role of a widget, several separated by spaces, as in
`dressed(QLabel(text), "heading")`:

- frames: `card` (related widgets on a separate background), `strip` (a bar across the window)
- labels: `title` (of a screen), `heading` (of a card), `muted` (captions, units), `value` (a number
  that is read often), `reading` (a number that is read from a distance), `good`, `warning`, `bad`
  (always with a word or a shape)
- buttons: `primary` (the next step, one per card), `danger` (stops or destroys), `quiet` (no
  frame until the pointer is over it), `compact` (narrow, for icons and table rows), `small` (as
  high as a line of text), `tight` (as high as its own text)
- number fields: `bare` (without arrows); fields: `bad` (with a refused text)

Everything else is styled by its type. A class that changes later needs `restyle(widget)`. Digits
have equal widths in every font here. A QWidget that is a card needs WA_StyledBackground; a QFrame
does not.
"""

from dataclasses import asdict
from pathlib import Path
from string import Template
from typing import TypeVar

from PyQt6.QtGui import QColor, QFont, QPalette
from PyQt6.QtWidgets import QApplication, QWidget

from workbench.gui.theme import Colours, Look

SHEET = Template("""
QMainWindow, QDialog { background: $ground; }
QToolTip { background: $card; color: $ink; border: 1px solid $line; padding: 4px 6px; }
QMenuBar { background: $ground; padding: 1px 4px; }
QMenuBar::item { padding: 4px 9px; border-radius: 5px; background: transparent; }
QMenuBar::item:selected { background: $line; }
QMenu { background: $card; border: 1px solid $line; padding: 4px; }
QMenu::item { padding: 5px 28px 5px 22px; border-radius: 4px; }
QMenu::item:selected { background: $accent; color: $on_accent; }
QMenu::item:disabled { color: $muted; background: transparent; }
QMenu::separator { height: 1px; background: $line; margin: 4px 8px; }

*[class~="card"] { background: $card; border: 1px solid $line; border-radius: 8px; }
*[class~="strip"] { background: $card; border: none; border-bottom: 1px solid $line; }
QLabel { background: transparent; border: none; }
QLabel[class~="title"] { font-size: ${title}pt; font-weight: 600; }
QLabel[class~="small"] { font-size: ${small}pt; }
QLabel[class~="heading"] { font-weight: 600; }
QLabel[class~="muted"] { color: $muted; }
QLabel[class~="value"] { font-size: ${value}pt; }
QLabel[class~="reading"] { font-size: ${reading}pt; font-weight: 600; }
QLabel[class~="good"] { color: $good; }
QLabel[class~="warning"] { color: $warning; }
QLabel[class~="bad"] { color: $bad; }

QPushButton, QToolButton {
  background: $card; color: $ink; border: 1px solid $line; border-radius: 6px;
  padding: 4px 11px; min-height: 20px;
}
QPushButton:hover, QToolButton:hover { border-color: $accent; }
QPushButton:pressed, QToolButton:pressed { background: $line; }
QPushButton:checked, QToolButton:checked { border: 2px solid $accent; padding: 3px 10px; }
QPushButton:disabled, QToolButton:disabled { color: $faint; background: transparent; }
QPushButton:focus, QToolButton:focus { border: 2px solid $accent; padding: 3px 10px; }
QPushButton[class~="primary"] {
  background: $accent; color: $on_accent; border-color: $accent; font-weight: 600;
}
QPushButton[class~="primary"]:hover { border-color: $ink; }
QPushButton[class~="primary"]:focus { border: 2px solid $ink; }
QPushButton[class~="primary"]:disabled {
  background: transparent; color: $faint; border-color: $line;
}
*[class~="danger"] { background: $bad; color: $on_bad; border-color: $bad; font-weight: 600; }
*[class~="danger"]:hover, *[class~="danger"]:focus { border: 2px solid $ink; padding: 3px 10px; }
*[class~="danger"]:disabled { background: transparent; color: $faint; border-color: $line; }
*[class~="quiet"] { background: transparent; border-color: transparent; }
*[class~="quiet"]:hover { border-color: $line; }
*[class~="quiet"]:focus { border-color: $accent; }
*[class~="compact"] { padding: 3px 6px; }
*[class~="compact"]:focus, *[class~="compact"]:checked { padding: 2px 5px; }
QToolButton[class~="small"] { padding: 1px 3px; min-height: 16px; }
QToolButton[class~="small"]:focus, QToolButton[class~="small"]:checked { padding: 0 2px; }
QToolButton[class~="tight"] { padding: 0 4px; min-height: 0; }
QToolButton[class~="tight"]:focus, QToolButton[class~="tight"]:checked { padding: 0 3px; }
QToolButton::menu-indicator { image: none; }
QFrame#side_bar { background: $card; border: none; border-right: 1px solid $line; }
*[class~="side"] {
  background: transparent; border: none; border-left: 4px solid transparent; border-radius: 0;
  color: $muted; padding: 7px 4px 7px 0; font-size: ${small}pt;
}
*[class~="side"]:hover { background: $ground; color: $ink; }
*[class~="side"]:checked {
  color: $ink; background: $ground; padding: 7px 4px 7px 0; border: none;
  border-left: 4px solid $accent;
}
*[class~="side"]:focus, *[class~="side"]:checked:focus {
  border: 2px solid $accent; border-left-width: 4px; padding: 5px 2px 5px 0;
}
QFrame#banner { background: $card; border: none; border-top: 1px solid $line; }
QFrame#guide { background: $card; border: none; border-top: 2px solid $accent; }
QFrame#banner[class~="note"] { border-left: 6px solid $accent; }
QFrame#banner[class~="warning"] { border-left: 6px solid $warning; }
QFrame#banner[class~="failure"] { border-left: 6px solid $bad; }
QFrame#top_bar { background: $card; border: none; border-bottom: 1px solid $line; }
QFrame#mode_badge QLabel { font-weight: 600; }
QFrame#mode_badge { background: $ground; border: 1px solid $line; border-radius: 6px; }

QLineEdit, QAbstractSpinBox, QComboBox, QPlainTextEdit, QTextEdit {
  background: $field; color: $ink; border: 1px solid $line; border-radius: 6px;
  padding: 3px 5px; min-height: 20px;
  selection-background-color: $accent; selection-color: $on_accent;
}
QLineEdit:hover, QAbstractSpinBox:hover, QComboBox:hover { border-color: $muted; }
QLineEdit:focus, QAbstractSpinBox:focus, QComboBox:focus, QPlainTextEdit:focus, QTextEdit:focus {
  border: 2px solid $accent; padding: 2px 4px;
}
QLineEdit:disabled, QAbstractSpinBox:disabled, QComboBox:disabled { color: $faint; }
QLineEdit[class~="bad"], QAbstractSpinBox[class~="bad"] {
  border: 2px solid $bad; padding: 2px 4px;
}
QAbstractSpinBox { padding-right: 17px; }
QAbstractSpinBox:focus { padding-right: 16px; }
QAbstractSpinBox::up-button, QAbstractSpinBox::down-button {
  subcontrol-origin: border; width: 17px; border: none; background: transparent;
}
QAbstractSpinBox::up-button { subcontrol-position: top right; margin-top: 2px; }
QAbstractSpinBox::down-button { subcontrol-position: bottom right; margin-bottom: 2px; }
QAbstractSpinBox::up-button:hover, QAbstractSpinBox::down-button:hover { background: $line; }
QAbstractSpinBox::up-arrow { image: url("$pictures/up.svg"); width: 10px; height: 10px; }
QAbstractSpinBox::down-arrow { image: url("$pictures/down.svg"); width: 10px; height: 10px; }
QAbstractSpinBox[class~="bare"], QAbstractSpinBox[class~="bare"]:focus { padding-right: 4px; }
QAbstractSpinBox[class~="bare"]::up-button, QAbstractSpinBox[class~="bare"]::down-button {
  width: 0;
}
QAbstractSpinBox[class~="bare"]::up-arrow, QAbstractSpinBox[class~="bare"]::down-arrow {
  image: none; width: 0; height: 0;
}
QComboBox { combobox-popup: 0; }
QComboBox, QComboBox:focus { padding-right: 2px; }
QComboBox::drop-down { border: none; width: 16px; }
QComboBox::down-arrow { image: url("$pictures/down.svg"); width: 10px; height: 10px; }
QComboBox QAbstractItemView {
  background: $card; color: $ink; border: 1px solid $line; outline: none;
  selection-background-color: $accent; selection-color: $on_accent;
}

QCheckBox, QRadioButton { background: transparent; spacing: 7px; padding: 2px; }
QCheckBox:disabled, QRadioButton:disabled { color: $faint; }
QCheckBox::indicator, QRadioButton::indicator, QAbstractItemView::indicator, QMenu::indicator {
  width: 14px; height: 14px; background: $field; border: 1px solid $muted; border-radius: 4px;
}
QMenu::indicator { width: 12px; height: 12px; margin-left: 4px; }
QRadioButton::indicator { border-radius: 8px; }
QCheckBox::indicator:hover, QRadioButton::indicator:hover { border-color: $accent; }
QCheckBox::indicator:checked, QAbstractItemView::indicator:checked, QMenu::indicator:checked {
  background: $accent; border-color: $accent; image: url("$pictures/check-$light.svg");
}
QRadioButton::indicator:checked {
  border-color: $accent;
  background: qradialgradient(cx: 0.5, cy: 0.5, radius: 0.5, fx: 0.5, fy: 0.5,
    stop: 0 $accent, stop: 0.5 $accent, stop: 0.6 $field, stop: 1 $field);
}
QCheckBox::indicator:focus, QRadioButton::indicator:focus { border: 2px solid $accent; }
QCheckBox::indicator:checked:focus { border-color: $ink; }
QCheckBox::indicator:disabled { background: $line; border-color: $line; }

QSlider:horizontal { min-height: 24px; }
QSlider:vertical { min-width: 24px; }
QSlider::groove:horizontal { height: 4px; background: $line; border-radius: 2px; }
QSlider::groove:vertical { width: 4px; background: $line; border-radius: 2px; }
QSlider::sub-page:horizontal, QSlider::add-page:vertical {
  background: $accent; border-radius: 2px;
}
QSlider::handle:horizontal {
  width: 14px; height: 14px; margin: -6px 0; border-radius: 8px;
  background: $accent; border: 1px solid $card;
}
QSlider::handle:vertical {
  width: 14px; height: 14px; margin: 0 -6px; border-radius: 8px;
  background: $accent; border: 1px solid $card;
}
QSlider::handle:horizontal:focus, QSlider::handle:vertical:focus {
  border: 3px solid $ink; width: 10px; height: 10px;
}
QSlider::handle:horizontal:disabled, QSlider::handle:vertical:disabled { background: $line; }
QSlider::sub-page:horizontal:disabled, QSlider::add-page:vertical:disabled { background: $line; }

QTabWidget::pane { border: none; border-top: 1px solid $line; }
QTabBar { qproperty-drawBase: 0; }
QTabBar::tab {
  background: transparent; color: $muted; padding: 6px 12px; border: none;
  border-bottom: 3px solid transparent; margin-right: 2px;
}
QTabBar::tab:hover { color: $ink; }
QTabBar::tab:selected { color: $ink; border-bottom-color: $accent; }
QTabBar::tab:focus { background: $line; }
QTabBar QToolButton::left-arrow { image: url("$pictures/left.svg"); width: 10px; height: 10px; }
QTabBar QToolButton::right-arrow { image: url("$pictures/right.svg"); width: 10px; height: 10px; }

QHeaderView { background: transparent; border: none; }
QHeaderView::section {
  background: $card; color: $muted; border: none; border-bottom: 1px solid $line; padding: 4px 8px;
}
QTableView, QTreeView, QListView {
  background: $field; alternate-background-color: $ground; border: 1px solid $line;
  border-radius: 6px; gridline-color: $line; outline: none;
  selection-background-color: $accent; selection-color: $on_accent;
}
QTableView:focus, QTreeView:focus, QListView:focus { border: 2px solid $accent; }
QTableView::item, QTreeView::item, QListView::item { padding: 3px 6px; }
QTableCornerButton::section { background: $card; border: none; }

QGroupBox { border: 1px solid $line; border-radius: 8px; margin-top: 10px; padding: 10px 8px 8px; }
QGroupBox::title { subcontrol-origin: margin; left: 10px; padding: 0 4px; }
QScrollArea { background: transparent; border: none; }
QScrollArea > QWidget > QWidget { background: transparent; }
QScrollBar:vertical { background: transparent; width: 11px; margin: 0; }
QScrollBar:horizontal { background: transparent; height: 11px; margin: 0; }
QScrollBar::handle { background: $line; border-radius: 4px; margin: 2px; }
QScrollBar::handle:vertical { min-height: 30px; }
QScrollBar::handle:horizontal { min-width: 30px; }
QScrollBar::handle:hover { background: $muted; }
QScrollBar::add-line, QScrollBar::sub-line { width: 0; height: 0; }
QScrollBar::add-page, QScrollBar::sub-page { background: transparent; }
QProgressBar {
  background: $line; border: none; border-radius: 4px; min-height: 8px; text-align: center;
}
QProgressBar::chunk { background: $accent; border-radius: 4px; }
QSplitter::handle { background: $ground; }
QSplitter::handle:hover, QSplitter::handle:focus { background: $accent; }
QStatusBar { background: $card; }
""")

PICTURES = Path(__file__).parent / "pictures"
SMALLEST_TEXT = 9.5
"""Digits below this size are hard to read [pt]."""
Widget = TypeVar("Widget", bound=QWidget)


def style_sheet(colours: Colours, points: float, pictures: str) -> str:
    """Return the sheet.

    Args:
        colours: light or dark ones.
        points: size of plain text [pt].
        pictures: folder with the arrows.
    """
    return SHEET.substitute(
        asdict(colours),
        faint=_between(colours.muted, colours.card),
        on_bad=colours.on_accent,
        title=f"{points * 1.45:.1f}",
        small=f"{points * 0.9:.1f}",
        value=f"{points * 1.2:.1f}",
        reading=f"{points * 1.9:.1f}",
        pictures=pictures,
        light="dark" if int(colours.ground[1:3], 16) < 128 else "light",
    )


def _between(one: str, other: str) -> str:
    """Return the mean of two colours, as #rrggbb: for disabled widgets."""
    parts = [
        (int(one[at : at + 2], 16) + int(other[at : at + 2], 16)) // 2 for at in range(1, 7, 2)
    ]
    return "#" + "".join(f"{part:02x}" for part in parts)


def apply_style(app: QApplication, look: Look) -> None:
    """Style the whole app, now and whenever the colours change."""
    app.setStyle("Fusion")
    app.setFont(_app_font(app.font()))
    _dress(app, look)
    look.changed.connect(lambda: _dress(app, look))


def restyle(widget: QWidget) -> None:
    """Apply a changed `class`."""
    style = widget.style()
    assert style is not None
    style.unpolish(widget)
    style.polish(widget)


def dressed(widget: Widget, name: str) -> Widget:
    """Set the class of a new widget, and return it."""
    widget.setProperty("class", name)
    return widget


def set_class(widget: QWidget, name: str) -> None:
    """Set the class of a widget, and restyle it if the class differs."""
    if widget.property("class") != name:
        widget.setProperty("class", name)
        restyle(widget)


def palette(colours: Colours) -> QPalette:
    """Return the colours of everything that the style sheet leaves to Qt."""
    made = QPalette()
    role = QPalette.ColorRole
    for which, name in (
        (role.Window, colours.ground),
        (role.WindowText, colours.ink),
        (role.Base, colours.field),
        (role.AlternateBase, colours.ground),
        (role.Text, colours.ink),
        (role.PlaceholderText, colours.muted),
        (role.Button, colours.card),
        (role.ButtonText, colours.ink),
        (role.Highlight, colours.accent),
        (role.HighlightedText, colours.on_accent),
        (role.Accent, colours.accent),
        (role.Link, colours.accent),
        (role.ToolTipBase, colours.card),
        (role.ToolTipText, colours.ink),
        (role.BrightText, colours.bad),
        (role.Mid, colours.line),
        (role.Light, colours.card),
        (role.Dark, colours.line),
    ):
        made.setColor(which, QColor(name))
    for which in (role.WindowText, role.Text, role.ButtonText):
        made.setColor(QPalette.ColorGroup.Disabled, which, QColor(colours.muted))
    return made


def _dress(app: QApplication, look: Look) -> None:
    app.setPalette(palette(look.colours))
    app.setStyleSheet(style_sheet(look.colours, app.font().pointSizeF(), PICTURES.as_posix()))


def _app_font(font: QFont) -> QFont:
    """Return a font for instruments: legible, and with digits of equal width."""
    font = QFont(font)
    font.setPointSizeF(max(font.pointSizeF(), SMALLEST_TEXT))
    font.setFeature(QFont.Tag("tnum"), 1)
    return font
