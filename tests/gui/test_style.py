"""The style sheet and the pictures: whole, in both lights, and readable."""

import re
from pathlib import Path

import pytest
from PyQt6.QtGui import QColor, QPalette
from PyQt6.QtWidgets import QApplication, QLabel, QPushButton, QSlider

from workbench.common.errors import WorkbenchError
from workbench.gui.icons import ICON_STROKES, icon, picture
from workbench.gui.style import STYLE_PICTURES_FOLDER, palette, set_class, style_sheet
from workbench.gui.theme import DARK_COLOURS, LIGHT_COLOURS


def luminance(colour):
    """Relative luminance, after the definition of WCAG 2."""
    parts = [QColor(colour).redF(), QColor(colour).greenF(), QColor(colour).blueF()]
    linear = [
        part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("colours", [LIGHT_COLOURS, DARK_COLOURS])
def test_the_sheet_is_understood(qtbot, colours):
    sheet = style_sheet(colours, 10.0, STYLE_PICTURES_FOLDER.as_posix())
    assert "$" not in sheet
    label = QLabel("x")
    qtbot.addWidget(label)
    label.setStyleSheet(sheet)  # Qt warns of what it cannot read, and a warning fails the test
    label.show()


@pytest.mark.parametrize(
    ("colours", "check"), [(LIGHT_COLOURS, "check-light.svg"), (DARK_COLOURS, "check-dark.svg")]
)
def test_the_pictures_that_it_names_are_there(colours, check):
    sheet = style_sheet(colours, 10.0, STYLE_PICTURES_FOLDER.as_posix())
    named = {Path(name).name for name in re.findall(r'url\("([^"]+)"\)', sheet)}
    assert named == {"up.svg", "down.svg", "left.svg", "right.svg", check}
    assert all((STYLE_PICTURES_FOLDER / name).is_file() for name in named)


@pytest.mark.parametrize("colours", [LIGHT_COLOURS, DARK_COLOURS])
def test_texts_on_coloured_buttons_can_be_read(colours):
    assert contrast(colours.on_accent, colours.accent) >= 4.5
    assert contrast(colours.on_accent, colours.bad) >= 4.5


@pytest.mark.parametrize("colours", [LIGHT_COLOURS, DARK_COLOURS])
def test_what_the_sheet_leaves_to_qt_has_our_colours(colours):
    made = palette(colours)
    assert made.color(QPalette.ColorRole.Window).name() == colours.ground
    assert made.color(QPalette.ColorRole.Highlight).name() == colours.accent
    group = QPalette.ColorGroup.Disabled
    assert made.color(group, QPalette.ColorRole.Text).name() == colours.muted


def test_a_changed_class_shows_at_once(qtbot):
    button = QPushButton("go")
    qtbot.addWidget(button)
    button.setStyleSheet('QPushButton[class~="primary"] { color: #123456; }')
    button.show()
    set_class(button, "primary compact")
    assert button.palette().color(QPalette.ColorRole.ButtonText).name() == "#123456"


def test_a_slider_without_the_focus_has_no_frame(qtbot):
    slider = QSlider()
    qtbot.addWidget(slider)
    slider.setStyleSheet(style_sheet(DARK_COLOURS, 10.0, STYLE_PICTURES_FOLDER.as_posix()))
    slider.resize(30, 200)
    slider.show()
    image = slider.grab().toImage()
    assert image.pixelColor(0, 100).name() != DARK_COLOURS.ink


def test_every_picture_is_drawn_in_its_colour(case, qapp):
    for name in ICON_STROKES:
        with case(name):
            pixmap = picture(name, QColor("#c22030"), 20, 2.0)
            assert (pixmap.width(), pixmap.devicePixelRatio()) == (40, 2.0)
            image = pixmap.toImage()
            solid = [
                image.pixelColor(x, y)
                for x in range(40)
                for y in range(40)
                if image.pixelColor(x, y).alpha() == 255
            ]
            assert len(solid) > 20
            for colour in solid:  # Qt's painter rounds
                assert abs(colour.red() - 0xC2) + abs(colour.green() - 0x20) <= 2


def test_an_unknown_picture_is_named(qapp):
    with pytest.raises(WorkbenchError, match="hoome"):
        picture("hoome", QColor("black"), 16)


def test_an_icon_has_a_picture_for_what_cannot_be_pressed(qapp):
    assert isinstance(QApplication.instance(), QApplication)
    made = icon("arm", QColor("black"), QColor("#d3d9e2"))
    assert len(made.availableSizes()) == 4
