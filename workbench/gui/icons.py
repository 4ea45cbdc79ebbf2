"""Icons and symbols of the app: strokes on a grid of 24, drawn in any colour and size."""

from PyQt6.QtCore import QByteArray, QRectF, Qt
from PyQt6.QtGui import QColor, QGuiApplication, QIcon, QPainter, QPixmap, QPixmapCache
from PyQt6.QtSvg import QSvgRenderer

from workbench.common.errors import unknown_name
from workbench.control.mode import FlightMode

ICON_STROKES = {
    "start": '<rect x="4" y="4" width="7" height="7" rx="1.2"/>'
    '<rect x="13" y="4" width="7" height="7" rx="1.2"/>'
    '<rect x="4" y="13" width="7" height="7" rx="1.2"/><path d="M16.5 13.5v6M13.5 16.5h6"/>',
    "home": '<path d="M4 11 12 4l8 7v9h-5v-6H9v6H4z"/>',
    "server": '<rect x="4" y="4" width="16" height="6.5" rx="1.5"/>'
    '<rect x="4" y="13.5" width="16" height="6.5" rx="1.5"/><path d="M7.5 7.3h2M7.5 16.8h2"/>',
    "joystick": '<circle cx="12" cy="12" r="8.5"/><circle cx="14" cy="10" r="3" fill="{colour}"/>'
    '<path d="M12 12 14 10"/>',
    "visualization": '<path d="M4 4v16h16"/><path d="M6.5 15.5l3.5-5 3 3 3-7 3 4"/>',
    "tuning": '<path d="M6 4v7M6 16v4M12 4v3M12 12v8M18 4v9M18 18v2"/>'
    '<path d="M3.5 13.5h5M9.5 9.5h5M15.5 15.5h5" stroke-width="2.6"/>',
    "settings": '<circle cx="12" cy="12" r="3"/><path d="M12 3.5v3M12 17.5v3M3.5 12h3M17.5 12h3'
    'M6 6l2.1 2.1M15.9 15.9 18 18M18 6l-2.1 2.1M8.1 15.9 6 18"/><circle cx="12" cy="12" r="6.2"/>',
    "arm": '<path d="M12 3.5v8"/><path d="M7 6.8a7.5 7.5 0 1 0 10 0"/>',
    "take_off": '<path d="M12 16V5M7 9.5 12 4.5l5 5M5 20h14"/>',
    "hold": '<path d="M9 5H5v4M15 5h4v4M9 19H5v-4M15 19h4v-4"/>'
    '<circle cx="12" cy="12" r="2.2" fill="{colour}"/>',
    "land": '<path d="M12 4v11M7 10.5l5 5 5-5M5 20h14"/>',
    "stop": '<path d="M8.3 3.5h7.4l4.8 4.8v7.4l-4.8 4.8H8.3l-4.8-4.8V8.3z" fill="{colour}"/>',
    "pause": '<path d="M8.5 5.5v13M15.5 5.5v13" stroke-width="3.4"/>',
    "more": '<path d="M5 12h.1M12 12h.1M19 12h.1" stroke-width="3.4"/>',
    "resume": '<path d="M7.5 5v14l11-7z" fill="{colour}"/>',
    "step": '<path d="M6 5.5v13l8-6.5z" fill="{colour}"/><path d="M18 5.5v13" stroke-width="3"/>',
    "reset": '<path d="M5 12a7 7 0 1 0 2.2-5.1L4.5 9.5"/><path d="M4.5 4.5v5h5"/>',
    "record": '<circle cx="12" cy="12" r="6.5" fill="{colour}"/>',
    "recording": '<rect x="6" y="6" width="12" height="12" rx="1.5" fill="{colour}"/>',
    "screenshot": '<path d="M4 8h4l1.5-2.5h5L16 8h4v11H4z"/><circle cx="12" cy="13.2" r="3.3"/>',
    "view3d": '<path d="M12 3.5 19.5 8v8L12 20.5 4.5 16V8z"/><path d="M4.5 8 12 12.5 19.5 8'
    'M12 12.5v8"/>',
    "note": '<circle cx="12" cy="12" r="8.5"/><path d="M12 11v5.5M12 7.4v.4"/>',
    "warning": '<path d="M12 4 21 19.5H3z"/><path d="M12 10v4.6M12 16.8v.3"/>',
    "failure": '<path d="M8.3 3.5h7.4l4.8 4.8v7.4l-4.8 4.8H8.3l-4.8-4.8V8.3z"/>'
    '<path d="M9 9l6 6M15 9l-6 6"/>',
    "close": '<path d="M6.5 6.5l11 11M17.5 6.5l-11 11"/>',
    "good": '<circle cx="12" cy="12" r="8.5"/><path d="M8 12.3l2.8 2.8L16 9.5"/>',
    "ground": '<path d="M4 18h16"/><path d="M12 5.5v8M9 11l3 3 3-3"/>',
    "hook": '<circle cx="12" cy="4.5" r="1.8"/><path d="M12 6.3v6.2a4.2 4.2 0 1 1-4.2 4.2"/>',
    "link": '<path d="M4 9.5a11.5 11.5 0 0 1 16 0M7 13a7 7 0 0 1 10 0"/>'
    '<circle cx="12" cy="17" r="1.6" fill="{colour}"/>',
    "pace": '<path d="M4.5 17a8.5 8.5 0 1 1 15 0"/><path d="M12 14l4-5"/>',
    "clock": '<circle cx="12" cy="12" r="8.5"/><path d="M12 7v5l3.5 2"/>',
    "battery": '<rect x="3.5" y="7.5" width="15" height="9" rx="1.5"/><path d="M21 10.5v3"/>',
}
MODE_ICONS = {
    FlightMode.OFF: "ground",
    FlightMode.ARMED: "arm",
    FlightMode.TAKING_OFF: "take_off",
    FlightMode.HOVERING: "hold",
    FlightMode.ASCENDING: "take_off",
    FlightMode.DESCENDING: "land",
    FlightMode.CRUISING: "resume",
    FlightMode.LANDING: "land",
}
"""Picture of each flight mode."""
_SVG_FRAME = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 24 24" fill="none" stroke="{colour}" '
    'stroke-width="1.8" stroke-linecap="round" stroke-linejoin="round">{body}</svg>'
)


def picture(name: str, colour: QColor, size: float, ratio: float | None = None) -> QPixmap:
    """Return a picture, rendered once for each colour and size.

    Args:
        name: name of the picture.
        colour: colour of its strokes.
        size: edge length in layout pixels.
        ratio: screen pixels per layout pixel; None for the finest screen's.

    Raises:
        WorkbenchError: if there is no picture of that name.
    """
    if name not in ICON_STROKES:
        raise unknown_name("icon", name, ICON_STROKES)
    app = QGuiApplication.instance()
    if ratio is None:
        ratio = app.devicePixelRatio() if isinstance(app, QGuiApplication) else 1.0
    key = f"{name} {colour.name()} {size} {ratio}"
    if (known := QPixmapCache.find(key)) is not None:
        return known
    pixmap = QPixmap(round(size * ratio), round(size * ratio))
    pixmap.setDevicePixelRatio(ratio)
    pixmap.fill(Qt.GlobalColor.transparent)
    body = ICON_STROKES[name].format(colour=colour.name())
    svg = _SVG_FRAME.format(colour=colour.name(), body=body)
    painter = QPainter(pixmap)
    QSvgRenderer(QByteArray(svg.encode())).render(painter, QRectF(0.0, 0.0, size, size))
    painter.end()
    QPixmapCache.insert(key, pixmap)
    return pixmap


def shape_icon(name: str, colour: QColor, size: float) -> QIcon:
    """Return a picture for an item of a list or a table; it keeps its colour if it is selected."""
    drawn = picture(name, colour, size)
    made = QIcon(drawn)
    made.addPixmap(drawn, QIcon.Mode.Selected)
    return made


def icon(name: str, colour: QColor, disabled: QColor | None = None) -> QIcon:
    """Return a picture for a button or a menu, in their sizes.

    Args:
        name: name of the picture.
        colour: colour of its strokes.
        disabled: colour of its strokes while the button is disabled.
    """
    made = QIcon()
    for size in (16, 20, 24, 32):
        made.addPixmap(picture(name, colour, size))
        if disabled is not None:
            made.addPixmap(picture(name, disabled, size), QIcon.Mode.Disabled)
    return made
