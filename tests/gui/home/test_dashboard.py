"""Where the cards of the Home screen stand."""

import itertools

import pytest
from PyQt6.QtCore import QRectF

from workbench.gui.home.card_plan import (
    MIN_LEGIBLE_SCALE,
    THREE_COLUMN_PLAN,
    TWO_COLUMN_PLAN,
    arrange_cards,
    choose_plan,
)

SIZES = (
    (608, 600),
    (760, 600),
    (1190, 600),
    (2400, 1500),
    (1280, 720),
    (1000, 900),
    (3600, 2000),
    (800, 1600),
)


def test_both_plans_have_the_same_cards():
    names = [
        sorted(name for column in columns for name in column)
        for *_, columns in (THREE_COLUMN_PLAN, TWO_COLUMN_PLAN)
    ]
    assert names[0] == names[1]
    assert len(set(names[0])) == len(names[0]) == 10


@pytest.mark.parametrize("size", SIZES)
def test_cards_fill_the_screen_and_do_not_overlap(size):
    _, total, spots = arrange_cards(*size)
    assert (total.width(), total.height()) == size
    screen = QRectF(0.0, 0.0, size[0] + 1e-6, size[1] + 1e-6)
    assert all(screen.contains(spot) for spot in spots.values())
    for (name, one), (second, other) in itertools.combinations(spots.items(), 2):
        assert not one.intersects(other), f"{name} overlaps {second}"


@pytest.mark.parametrize("plan", [THREE_COLUMN_PLAN, TWO_COLUMN_PLAN])
def test_the_slots_of_a_plan_fit_into_its_own_size(plan):
    width, height, _ = plan
    scale, _, spots = arrange_cards(width, height)
    assert scale == 1.0
    assert max(spot.bottom() for spot in spots.values()) <= height


def test_beside_the_3d_view_there_are_two_columns_and_else_three():
    assert choose_plan(760, 600) is TWO_COLUMN_PLAN
    assert choose_plan(1190, 600) is THREE_COLUMN_PLAN
    assert choose_plan(2400, 1500) is THREE_COLUMN_PLAN
    assert choose_plan(800, 1600) is TWO_COLUMN_PLAN
    assert choose_plan(1182, 610) is THREE_COLUMN_PLAN
    assert choose_plan(936, 545) is TWO_COLUMN_PLAN  # a window of 1024 x 640
    assert choose_plan(853, 400) is TWO_COLUMN_PLAN  # three would be too wide
    assert arrange_cards(936, 545)[0] == MIN_LEGIBLE_SCALE  # it scrolls, with legible text


def test_text_grows_with_the_window():
    assert arrange_cards(2400, 1500)[0] == pytest.approx(2400 / 1190)
    assert arrange_cards(760, 600)[0] == 1.0


def test_a_screen_that_is_too_small_is_larger_than_its_window():
    scale, total, _ = arrange_cards(400, 200)
    assert scale == MIN_LEGIBLE_SCALE
    assert total.width() > 400 and total.height() > 200
