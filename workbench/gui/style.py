"""The app's style sheet and palette, made of the colours of `Look`.

What a widget is for is said by its property `class`, several with spaces between, as in
`dressed(QLabel(text), "heading")`:

- frames: `card` (what belongs together, on its own ground), `strip` (a bar across the window)
- labels: `title` (of a screen), `heading` (of a card), `muted` (captions, units), `value` (a number
  that is read often), `reading` (a number that is read from afar), `good`, `warning`, `bad` (always
  with a word or a shape besides)
- buttons: `primary` (what to press next, one a card), `danger` (stops or destroys), `quiet` (no
  frame until it is pointed at), `compact` (narrow, for icons and table rows), `small` (as high as a
  line of text)
- number fields: `bare` (without arrows); fields: `bad` (what stands in it cannot be)

Everything else is styled by its kind. A class that changes later needs `restyle(widget)`. Digits
are of equal width in every font here. A QWidget that is a card needs WA_StyledBackground; a QFrame
does not.
"""

from pathlib import Path
from typing import TypeVar

from PyQt6.QtGui import QColor, QFont, QPalette
from PyQt6.QtWidgets import QApplication, QWidget

from workbench.gui.style_sheet import style_sheet
from workbench.gui.theme import Colours, Look

PICTURES = Path(__file__).parent / "pictures"
SMALLEST_TEXT = 9.5
"""Below this size digits are hard to tell apart [pt]."""
Widget = TypeVar("Widget", bound=QWidget)


def apply_style(app: QApplication, look: Look) -> None:
    """Dress the whole app, now and whenever the colours change."""
    app.setStyle("Fusion")
    app.setFont(_app_font(app.font()))
    _dress(app, look)
    look.changed.connect(lambda: _dress(app, look))


def restyle(widget: QWidget) -> None:
    """Let a changed `class` show."""
    style = widget.style()
    assert style is not None
    style.unpolish(widget)
    style.polish(widget)


def dressed(widget: Widget, name: str) -> Widget:
    """Give a new widget its class, and return it."""
    widget.setProperty("class", name)
    return widget


def set_class(widget: QWidget, name: str) -> None:
    """Give a widget a class, and let it show where it is another."""
    if widget.property("class") != name:
        widget.setProperty("class", name)
        restyle(widget)


def palette(colours: Colours) -> QPalette:
    """Return the colours of whatever the style sheet leaves to Qt."""
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
    """Return a font for instruments: no smaller than can be read, with digits of equal width."""
    font = QFont(font)
    font.setPointSizeF(max(font.pointSizeF(), SMALLEST_TEXT))
    font.setFeature(QFont.Tag("tnum"), 1)
    return font
