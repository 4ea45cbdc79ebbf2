"""Where the cards of the Home screen stand; plain arithmetic, without Qt."""

from dataclasses import dataclass

MARGIN = 10.0
"""Around all cards, at scale 1 [px]."""
GAP = 8.0
"""Between cards, at scale 1 [px]."""
SMALLEST = 0.8
"""Scale under which text is no longer readable: then the screen scrolls."""
WIDE_ENOUGH = 0.75
"""Three columns are taken where text in them is not smaller than this share of that in two..."""
LARGE_ENOUGH = 0.95
"""...and not smaller than at this scale, unless it would be in two as well."""


@dataclass(frozen=True)
class Slot:
    """A place in a column.

    Attributes:
        name: of the card.
        height: that it needs at scale 1 [px].
        stretch: share that it takes of what is left.
    """

    name: str
    height: float
    stretch: float = 0.0


@dataclass(frozen=True)
class Plan:
    """Columns of equal width.

    Attributes:
        width: at which the scale is 1 [px].
        height: likewise.
        columns: slots from top to bottom.
    """

    width: float
    height: float
    columns: tuple[tuple[Slot, ...], ...]

    def scale(self, width: float, height: float) -> float:
        """Return by how much larger everything may be on so many pixels."""
        return min(width / self.width, height / self.height)


@dataclass(frozen=True)
class Spot:
    """Where a card stands [px]."""

    name: str
    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True)
class Arrangement:
    """All cards.

    Attributes:
        scale: of text and margins.
        width: that they take [px].
        height: that they take [px].
        spots: one a card.
    """

    scale: float
    width: float
    height: float
    spots: tuple[Spot, ...]


THREE = Plan(
    1190.0,
    600.0,
    (
        (
            Slot("clock", 76.0),
            Slot("condition", 92.0),
            Slot("motion", 132.0),
            Slot("battery", 62.0),
            Slot("rotors", 140.0, 1.0),
        ),
        (Slot("attitude", 290.0, 0.7), Slot("imu", 116.0, 0.15), Slot("height", 112.0, 0.15)),
        (Slot("lidar", 290.0, 1.2), Slot("gps", 230.0, 1.0)),
    ),
)
TWO = Plan(
    760.0,
    600.0,
    (
        (
            Slot("clock", 62.0),
            Slot("attitude", 190.0, 1.0),
            Slot("motion", 118.0),
            Slot("imu", 86.0),
            Slot("height", 86.0),
        ),
        (
            Slot("condition", 82.0),
            Slot("battery", 48.0),
            Slot("lidar", 160.0, 1.0),
            Slot("gps", 130.0, 0.6),
            Slot("rotors", 126.0, 0.4),
        ),
    ),
)


def choose_plan(width: float, height: float) -> Plan:
    """Return the plan that shows most on so many pixels."""
    three, two = THREE.scale(width, height), TWO.scale(width, height)
    return THREE if three >= min(two, max(LARGE_ENOUGH, WIDE_ENOUGH * two)) else TWO


def arrange(width: float, height: float) -> Arrangement:
    """Return where the cards stand on so many pixels, or on more where these are too few."""
    plan = choose_plan(width, height)
    scale = plan.scale(width, height)
    if scale < SMALLEST:
        scale = SMALLEST
        width, height = max(width, scale * plan.width), max(height, scale * plan.height)
    count = len(plan.columns)
    margin, gap = scale * MARGIN, scale * GAP
    column = (width - 2 * margin - (count - 1) * gap) / count
    spots: list[Spot] = []
    for index, slots in enumerate(plan.columns):
        left, top = margin + index * (column + gap), margin
        spare = height - 2 * margin - (len(slots) - 1) * gap
        spare -= sum(scale * slot.height for slot in slots)
        total = sum(slot.stretch for slot in slots)
        for slot in slots:
            tall = scale * slot.height + max(0.0, spare) * slot.stretch / total
            spots.append(Spot(slot.name, left, top, column, tall))
            top += tall + gap
    return Arrangement(scale, width, height, tuple(spots))
