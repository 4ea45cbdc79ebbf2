"""The Home screen in windows of several sizes and looks, and for a screen reader."""

from dataclasses import replace

import pytest
from PyQt6.QtWidgets import QScrollBar

from workbench.gui.home.home_screen import HomeScreen


class Clock:
    """A clock that stands until it is moved."""

    def __init__(self):
        self.now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def home(qtbot, workspace, canned, clock):
    """The screen at the end of the flight."""
    made = HomeScreen(workspace, clock=clock)
    qtbot.addWidget(made)
    made.resize(1190, 600)
    workspace.signals.begin(canned.views[0].topics)
    made.begin(canned.views[0])
    for published in canned.published[-20:]:
        workspace.flight.streamed.emit(list(published))
    clock.now += 1.0
    made.show_view(canned.views[-1])
    return made


@pytest.mark.parametrize("size", [(760, 600), (1190, 600), (2400, 1500)])
def test_no_scroll_bar_is_needed(home, size):
    home.resize(*size)
    home.show()
    home.grab()
    assert not any(bar.isVisible() for bar in home.findChildren(QScrollBar))
    for card in home.cards.values():
        assert home.rect().contains(card.geometry())


def test_a_window_that_is_too_small_scrolls(home, qtbot):
    home.resize(420, 300)
    home.show()
    qtbot.waitUntil(lambda: any(bar.isVisible() for bar in home.findChildren(QScrollBar)))


def test_text_grows_with_the_window(home):
    home.resize(1190, 600)
    home.show()
    small = home.cards["motion"].table.text_size
    home.resize(2400, 1500)
    home.grab()
    assert home.cards["motion"].table.text_size == pytest.approx(2400 / 1190 * small, rel=0.01)


def test_every_card_has_a_name_and_says_what_it_shows(home):
    for card in home.cards.values():
        assert card.accessibleName()
        assert card.accessibleDescription(), card.name
    assert "m/s" in home.cards["motion"].accessibleDescription()


def test_the_same_view_paints_nothing(home, canned, clock, monkeypatch):
    view = canned.views[-1]
    home.grab()  # with this, all have their places
    clock.now += 1.0
    home.show_view(view)
    updates = []
    for card in home.cards.values():
        for part in (card, *card.parts):
            monkeypatch.setattr(part, "update", lambda *_, part=part: updates.append(part))
    clock.now += 1.0
    home.show_view(view)
    assert updates == []


def test_a_dark_look_paints_it_again(home, workspace):
    light = home.grab().toImage()
    workspace.preferences.set("theme", "dark")
    dark = home.grab().toImage()
    assert light != dark
    assert dark.pixelColor(2, 2) == workspace.look.colour("ground")


@pytest.mark.parametrize("count", [4, 6, 8, 12])
@pytest.mark.parametrize("width", [760, 1190])
def test_the_next_flight_may_have_other_rotors(home, workspace, canned, count, width):
    view = canned.views[-1]
    rotors = (view.vehicle.rotors * 3)[:count]
    other = replace(
        view,
        vehicle=replace(view.vehicle, rotors=rotors),
        snapshot=replace(view.snapshot, thrusts=(5.0,) * count, time=0.0),
    )
    workspace.signals.begin(view.topics)
    home.begin(other)
    home.resize(width, 600)
    home.grab()
    assert len(home.cards["rotors"].bars.readings) == count
    assert home.cards["gps"].map.trail.points == []
