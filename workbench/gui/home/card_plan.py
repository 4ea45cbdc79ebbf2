"""The plans of the Home screen: which card stands where, and how large text can be."""

from collections.abc import Mapping, Sequence

from PyQt6.QtCore import QRectF, QSizeF

CARDS_MARGIN_PX = 10.0
"""Margin around all cards, at scale 1 [px]."""
CARDS_GAP_PX = 8.0
"""Space between cards, at scale 1 [px]."""
MIN_LEGIBLE_SCALE = 1.0
"""Least scale with legible text: below it, all cards together are higher than the screen..."""
MIN_WIDTH_SCALE = 0.8
"""...which also scrolls sideways if it is narrower than at this scale."""
MIN_THREE_COLUMN_RATIO = 0.75
"""Three columns are used if their text is at least this share of the size in two columns..."""
MIN_THREE_COLUMN_SCALE = 0.95
"""...and at least of this scale, unless it would be smaller in two columns as well."""
MIN_CARD_WIDTHS_PX = {"motion": 309.0}
"""Least width at scale 1 of cards that need more than a column of a narrow screen [px]."""
CardPlan = tuple[float, float, Sequence[Mapping[str, tuple[float, float]]]]
"""Width and height at scale 1 [px], and columns, of equal width if that is enough: for each card
from top to bottom its least height at scale 1 [px], and its share of the remaining height."""
THREE_COLUMN_PLAN: CardPlan = (
    1190.0,
    570.0,
    (
        {
            "clock": (76.0, 0.0),
            "condition": (92.0, 0.0),
            "motion": (132.0, 0.0),
            "battery": (62.0, 0.0),
            "rotors": (140.0, 1.0),
        },
        {"attitude": (280.0, 0.7), "imu": (138.0, 0.15), "height": (112.0, 0.15)},
        {"lidar": (290.0, 1.2), "gps": (230.0, 1.0)},
    ),
)
TWO_COLUMN_PLAN: CardPlan = (
    760.0,
    600.0,
    (
        {
            "clock": (62.0, 0.0),
            "attitude": (174.0, 1.0),
            "motion": (118.0, 0.0),
            "imu": (104.0, 0.0),
            "height": (86.0, 0.0),
        },
        {
            "condition": (82.0, 0.0),
            "battery": (48.0, 0.0),
            "lidar": (160.0, 1.0),
            "gps": (130.0, 0.6),
            "rotors": (126.0, 0.4),
        },
    ),
)


def plan_scale(plan: CardPlan, width: float, height: float) -> float:
    """Return the scale at which a plan fits a number of pixels."""
    return min(width / plan[0], height / plan[1])


def choose_plan(width: float, height: float) -> CardPlan:
    """Return the plan with the best use of a number of pixels."""
    three, two = (
        plan_scale(THREE_COLUMN_PLAN, width, height),
        plan_scale(TWO_COLUMN_PLAN, width, height),
    )
    enough = min(two, max(MIN_THREE_COLUMN_SCALE, MIN_THREE_COLUMN_RATIO * two))
    fits = width >= MIN_WIDTH_SCALE * THREE_COLUMN_PLAN[0]  # without scrolling sideways
    return THREE_COLUMN_PLAN if fits and three >= enough else TWO_COLUMN_PLAN


def arrange_cards(width: float, height: float) -> tuple[float, QSizeF, dict[str, QRectF]]:
    """Return the scale of text and margins, the size of all cards, and the area of each [px].

    Args:
        width: width to fill [px]; the cards need more if it is too small.
        height: height to fill [px], likewise.
    """
    plan = choose_plan(width, height)
    scale = max(MIN_LEGIBLE_SCALE, plan_scale(plan, width, height))
    width, height = (
        max(width, MIN_WIDTH_SCALE * plan[0]),
        max(height, MIN_LEGIBLE_SCALE * plan[1]),
    )
    columns = plan[2]
    margin, gap = scale * CARDS_MARGIN_PX, scale * CARDS_GAP_PX
    room = width - 2 * margin - (len(columns) - 1) * gap
    spots: dict[str, QRectF] = {}
    left = margin
    for column, across in zip(columns, _column_widths(columns, scale, room), strict=True):
        top = margin
        spare = height - 2 * margin - (len(column) - 1) * gap
        spare -= sum(scale * least for least, _ in column.values())
        total = sum(share for _, share in column.values())
        for name, (least, share) in column.items():
            tall = scale * least + max(0.0, spare) * share / total
            spots[name] = QRectF(left, top, across, tall)
            top += tall + gap
        left += across + gap
    return scale, QSizeF(width, height), spots


def _column_widths(
    columns: Sequence[Mapping[str, object]], scale: float, room: float
) -> Sequence[float]:
    """Return equal widths of columns, but for those whose cards need more [px]."""
    least = [
        scale * max(MIN_CARD_WIDTHS_PX.get(name, 0.0) for name in column) for column in columns
    ]
    equal = room / len(columns)
    wide = [each for each in least if each > equal]
    rest = (room - sum(wide)) / max(1, len(columns) - len(wide))
    return [each if each > equal else rest for each in least]
