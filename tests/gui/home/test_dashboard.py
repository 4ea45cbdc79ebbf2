"""Where the cards of the Home screen stand."""

import itertools

import pytest
from PyQt6.QtCore import QRectF

from workbench.gui.home.home_screen import SMALLEST, THREE, TWO, arrange, choose_plan

SIZES = ((760, 600), (1190, 600), (2400, 1500), (1280, 720), (1000, 900), (3600, 2000), (800, 1600))


def test_both_plans_have_the_same_cards():
    names = [
        sorted(slot.name for column in plan.columns for slot in column) for plan in (THREE, TWO)
    ]
    assert names[0] == names[1]
    assert len(set(names[0])) == len(names[0]) == 10


@pytest.mark.parametrize("size", SIZES)
def test_cards_fill_the_screen_and_do_not_overlap(size):
    arrangement = arrange(*size)
    assert (arrangement.width, arrangement.height) == size
    screen = QRectF(0.0, 0.0, size[0] + 1e-6, size[1] + 1e-6)
    assert all(screen.contains(spot) for spot in arrangement.spots.values())
    for (name, one), (second, other) in itertools.combinations(arrangement.spots.items(), 2):
        assert not one.intersects(other), f"{name} overlaps {second}"


@pytest.mark.parametrize("plan", [THREE, TWO])
def test_the_slots_of_a_plan_fit_into_its_own_size(plan):
    arrangement = arrange(plan.width, plan.height)
    assert arrangement.scale == 1.0
    bottoms = [spot.bottom() for spot in arrangement.spots.values()]
    assert max(bottoms) <= plan.height


def test_beside_the_3d_view_there_are_two_columns_and_else_three():
    assert choose_plan(760, 600) is TWO
    assert choose_plan(1190, 600) is THREE
    assert choose_plan(2400, 1500) is THREE
    assert choose_plan(800, 1600) is TWO
    assert choose_plan(1182, 610) is THREE
    assert choose_plan(936, 545) is TWO  # a window of 1024 x 640
    assert arrange(936, 545).scale > SMALLEST


def test_text_grows_with_the_window():
    assert arrange(2400, 1500).scale == pytest.approx(2400 / 1190)
    assert arrange(760, 600).scale == 1.0


def test_a_screen_that_is_too_small_is_larger_than_its_window():
    arrangement = arrange(400, 200)
    assert arrangement.scale == SMALLEST
    assert arrangement.width > 400 and arrangement.height > 200
