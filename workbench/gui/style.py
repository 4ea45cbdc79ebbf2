"""The app's style sheet and palette, made from the colours of `Look`.

The property `class` states the role of a widget, several separated by spaces, as in
`with_class(Label(text), "heading")`:

- frames: `card` (related widgets on a separate background), `strip` (a bar across the window)
- labels: `title` (of a screen), `heading` (of a card), `muted` (captions, units), `value` (a number
  that is read often), `reading` (a number that is read from a distance), `good`, `warning`, `bad`
  (always with a word or a shape)
- buttons: `primary` (the next step, one per card), `danger` (stops or destroys), `quiet` (no
  frame until the pointer is over it), `compact` (narrow, for icons and table rows), `small` (as
  high as a line of text), `tight` (as high as its own text)
- tables: `numbers` (dense, on a card)
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

STYLE_SHEET_FILE = Path(__file__).with_name("style.qss")
STYLE_PICTURES_FOLDER = Path(__file__).parent / "pictures"
MIN_INSTRUMENT_TEXT_PT, MIN_TEXT_PT = 9.5, 9.0
"""Least sizes of plain text, with digits that are easy to read, and of any text [pt]."""
Widget = TypeVar("Widget", bound=QWidget)


def style_sheet(colours: Colours, points: float, pictures: str) -> str:
    """Return the sheet.

    Args:
        colours: light or dark ones.
        points: size of plain text [pt].
        pictures: folder with the arrows.
    """
    return Template(STYLE_SHEET_FILE.read_text(encoding="utf-8")).substitute(
        asdict(colours),
        faint=_mean_colour(colours.muted, colours.card),
        on_bad=colours.on_accent,
        title=f"{points * 1.45:.1f}",
        small=f"{max(MIN_TEXT_PT, points * 0.9):.1f}",
        value=f"{points * 1.2:.1f}",
        reading=f"{points * 1.9:.1f}",
        pictures=pictures,
        light="dark" if int(colours.ground[1:3], 16) < 128 else "light",
    )


def _mean_colour(one: str, other: str) -> str:
    """Return the mean of two colours, as #rrggbb: for disabled widgets."""
    parts = [
        (int(one[at : at + 2], 16) + int(other[at : at + 2], 16)) // 2 for at in range(1, 7, 2)
    ]
    return "#" + "".join(f"{part:02x}" for part in parts)


def apply_style(app: QApplication, look: Look) -> None:
    """Style the whole app, now and whenever the colours change."""
    app.setStyle("Fusion")
    app.setFont(_app_font(app.font()))
    _apply_colours(app, look)
    look.changed.connect(lambda: _apply_colours(app, look))


def restyle(widget: QWidget) -> None:
    """Apply a changed `class`."""
    style = widget.style()
    assert style is not None
    style.unpolish(widget)
    style.polish(widget)


def with_class(widget: Widget, name: str) -> Widget:
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


def _apply_colours(app: QApplication, look: Look) -> None:
    app.setPalette(palette(look.colours))
    app.setStyleSheet(
        style_sheet(look.colours, app.font().pointSizeF(), STYLE_PICTURES_FOLDER.as_posix())
    )


def _app_font(font: QFont) -> QFont:
    """Return a font for instruments: legible, and with digits of equal width."""
    font = QFont(font)
    font.setPointSizeF(max(font.pointSizeF(), MIN_INSTRUMENT_TEXT_PT))
    font.setFeature(QFont.Tag("tnum"), 1)
    return font
