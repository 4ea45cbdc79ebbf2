"""Colours can be read: contrast by WCAG 2.1, computed here."""

import dataclasses
import itertools

import pytest
from PyQt6.QtGui import QColor

from workbench.gui.theme import DARK_COLOURS, LIGHT_COLOURS

GROUNDS = ("ground", "card", "field")
INKS = ("ink", "muted", "accent", "good", "warning", "bad")


def luminance(colour):
    """Return the relative luminance of #rrggbb."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(a, b):
    light, dark = sorted((luminance(a), luminance(b)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_black_on_white_has_the_largest_contrast():
    assert contrast("#000000", "#ffffff") == pytest.approx(21.0)


def test_text_can_be_read(case):
    for ink, ground in [*itertools.product(INKS, GROUNDS)]:
        for colours in [LIGHT_COLOURS, DARK_COLOURS]:
            with case(ink, ground, colours):
                assert contrast(getattr(colours, ink), getattr(colours, ground)) >= 4.5


@pytest.mark.parametrize("colours", [LIGHT_COLOURS, DARK_COLOURS], ids=["light", "dark"])
def test_text_on_the_accent_can_be_read(colours):
    assert contrast(colours.accent, colours.on_accent) >= 4.5


@pytest.mark.parametrize("colours", [LIGHT_COLOURS, DARK_COLOURS], ids=["light", "dark"])
def test_curves_stand_out_from_their_field(colours):
    assert all(contrast(curve, colours.field) >= 3.0 for curve in colours.curves)


def test_every_colour_is_one():
    for colours in (LIGHT_COLOURS, DARK_COLOURS):
        for field in dataclasses.fields(colours):
            value = getattr(colours, field.name)
            for text in value if isinstance(value, tuple) else (value,):
                assert QColor(text).isValid()


def test_the_theme_follows_the_preference(workspace, qtbot):
    workspace.preferences.set("theme", "light")
    with qtbot.waitSignal(workspace.look.changed):
        workspace.preferences.set("theme", "dark")
    assert workspace.look.is_dark
    assert workspace.look.colour("ink") == QColor(DARK_COLOURS.ink)
    assert workspace.look.curve(8) == QColor(DARK_COLOURS.curves[0])
