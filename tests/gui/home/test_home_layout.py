"""The Home screen in windows of several sizes and looks, and for a screen reader."""

from dataclasses import replace

import pytest
from PyQt6.QtWidgets import QScrollBar


@pytest.mark.parametrize("size", [(760, 600), (1190, 600), (2400, 1500)])
def test_no_scroll_bar_is_needed(flown, size):
    flown.resize(*size)
    flown.show()
    flown.grab()
    assert not any(bar.isVisible() for bar in flown.findChildren(QScrollBar))
    for card in flown.cards.values():
        assert flown.rect().contains(card.geometry())


def test_a_window_that_is_too_small_scrolls(flown, qtbot):
    flown.resize(420, 300)
    flown.show()
    qtbot.waitUntil(lambda: any(bar.isVisible() for bar in flown.findChildren(QScrollBar)))


def test_text_grows_with_the_window(flown):
    flown.resize(1190, 600)
    flown.show()
    small = flown.cards["motion"].table.fontInfo().pixelSize()
    flown.resize(2400, 1500)
    flown.grab()
    large = flown.cards["motion"].table.fontInfo().pixelSize()
    assert large == pytest.approx(2400 / 1190 * small, rel=0.05)


def test_every_card_has_a_name_and_says_what_it_shows(flown):
    for card in flown.cards.values():
        assert card.accessibleName()
        assert card.accessibleDescription(), card.name
    assert "m/s" in flown.cards["motion"].accessibleDescription()


def test_the_same_view_paints_nothing(flown, canned, clock, monkeypatch):
    view = canned.views[-1]
    flown.grab()  # with this, all have their places
    clock.now += 1.0
    flown.show_view(view)
    updates = []
    for card in flown.cards.values():
        for part in (card, *card.parts):
            monkeypatch.setattr(part, "update", lambda *_, part=part: updates.append(part))
    clock.now += 1.0
    flown.show_view(view)
    assert updates == []


def test_a_dark_look_paints_it_again(flown, workspace):
    light = flown.grab().toImage()
    workspace.preferences.set("theme", "dark")
    dark = flown.grab().toImage()
    assert light != dark
    assert dark.pixelColor(2, 2) == workspace.look.colour("ground")


@pytest.mark.parametrize("count", [4, 6, 8, 12])
@pytest.mark.parametrize("width", [760, 1190])
def test_the_next_flight_may_have_other_rotors(flown, workspace, canned, count, width):
    view = canned.views[-1]
    rotors = (view.vehicle.rotors * 3)[:count]
    other = replace(
        view,
        vehicle=replace(view.vehicle, rotors=rotors),
        snapshot=replace(view.snapshot, thrusts=(5.0,) * count, time=0.0),
    )
    workspace.signals.begin(view.topics)
    flown.begin(other)
    flown.resize(width, 600)
    flown.grab()
    assert len(flown.cards["rotors"].bars.readings) == count
    assert flown.cards["gps"].map.trail.points == []
