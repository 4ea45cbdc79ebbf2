"""The part of the world that a map shows: in round steps, so that it seldom moves; no Qt."""

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass

SLACK = 0.7
"""The content must fit into this share of a smaller step before that step is used..."""
PATIENCE = 2.0
"""...for this time [s]."""

LEAST = 2.0
"""Least half of the map's shorter side [m]."""
MARGIN = 1.25
"""Margin around the visible content, as a factor."""
EDGE = 0.9
"""Share of the reach that must contain everything."""
GRID = 8.0
"""The centre is a whole multiple of the reach divided by this."""
SCALE_SHARE = 0.4
"""Largest share of the map's width for the scale bar."""


def round_reach(reach: float) -> float:
    """Return the least of 1, 2, 5 times a power of ten that is not below a reach."""
    power = 10.0 ** math.floor(math.log10(reach))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= reach * 0.999999)


class SteadyScale:
    """Widens at once if the content needs it, and narrows only after some time.

    Args:
        least: least reach [m].
        most: largest reach [m].
    """

    def __init__(self, least: float, most: float = math.inf) -> None:
        self._least = least
        self._most = most
        self.reset()

    def reset(self) -> None:
        """Clear the content."""
        self.reach = self._least
        self._since = math.inf

    def take(self, wanted: float, time: float) -> float:
        """Return the reach.

        Args:
            wanted: reach of the content [m].
            time: present time of any monotonic clock [s].
        """
        wanted = min(self._most, max(self._least, wanted)) if wanted > 0.0 else self._least
        step = min(self._most, round_reach(wanted))
        if step > self.reach:
            self.reach, self._since = step, math.inf
        elif round_reach(wanted / SLACK) < self.reach:
            self._since = min(self._since, time)
            if time - self._since >= PATIENCE:
                self.reach, self._since = max(self._least, round_reach(wanted / SLACK)), math.inf
        else:
            self._since = math.inf
        return self.reach


@dataclass(frozen=True)
class Place:
    """A place in W [m]."""

    east: float
    north: float


@dataclass(frozen=True)
class MapFrame:
    """The visible part.

    Attributes:
        middle: its centre.
        reach: half of the shorter side [m].
    """

    middle: Place
    reach: float

    def place(self, x: float, y: float, width: float, height: float) -> Place:
        """Return the place at a pixel of a map of a given size [px]."""
        scale = self.scale(width, height)
        return Place(
            self.middle.east + (x - width / 2) / scale,
            self.middle.north - (y - height / 2) / scale,
        )

    def pixels(self, place: Place, width: float, height: float) -> tuple[float, float]:
        """Return a place's position on a map of a size [px], from its top left; north is up."""
        scale = self.scale(width, height)
        return (
            width / 2 + (place.east - self.middle.east) * scale,
            height / 2 - (place.north - self.middle.north) * scale,
        )

    def scale(self, width: float, height: float) -> float:
        """Return pixels per metre."""
        return min(width, height) / 2 / self.reach

    def bar(self, width: float, height: float) -> float:
        """Return a round length for the scale bar [m]."""
        longest = SCALE_SHARE * width / self.scale(width, height)
        step = round_reach(longest)
        if step <= longest * 1.000001:
            return step
        return next(each for each in (step / 2.0, step / 2.5, step / 5.0) if _is_round(each))


STEPS = tuple(step * 10.0**power for power in range(4) for step in (1.0, 2.0, 5.0))
"""Selectable reaches of the wheel [m]."""


class SteadyFrame:
    """Chooses the visible part: it contains everything, and its size and centre move in steps."""

    def __init__(self) -> None:
        self.reset(Place(0.0, 0.0))

    def reset(self, home: Place, least: float = LEAST) -> None:
        """Start around a place.

        Args:
            home: centre of the map.
            least: least half of the map's shorter side [m].
        """
        self._scale = SteadyScale(least)
        self.frame = MapFrame(home, least)

    def zoom(self, steps: int) -> None:
        """Zoom out, or in with a negative number, at the next `take`.

        All required places stay visible.
        """
        place = bisect_left(STEPS, self.frame.reach) + steps
        self._scale = SteadyScale(STEPS[min(max(place, STEPS.index(LEAST)), len(STEPS) - 1)])

    def take(self, places: Iterable[Place], time: float) -> MapFrame:
        """Return the part that shows all places.

        Args:
            places: places that must be visible.
            time: present time [s].
        """
        seen = list(places)
        east, north = [each.east for each in seen], [each.north for each in seen]
        half = max(max(east) - min(east), max(north) - min(north)) / 2.0
        reach = self._scale.take(MARGIN * half, time)
        middle = Place((max(east) + min(east)) / 2.0, (max(north) + min(north)) / 2.0)
        now = self.frame
        room = EDGE * reach
        fits = reach == now.reach and all(
            abs(each.east - now.middle.east) <= room and abs(each.north - now.middle.north) <= room
            for each in seen
        )
        if not fits:
            grid = reach / GRID
            self.frame = MapFrame(
                Place(grid * round(middle.east / grid), grid * round(middle.north / grid)), reach
            )
        return self.frame


def _is_round(value: float) -> bool:
    leading = value / 10.0 ** math.floor(math.log10(value) + 1e-9)
    return any(abs(leading - each) < 1e-6 for each in (1.0, 2.0, 5.0))
