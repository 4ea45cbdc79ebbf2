"""The part of the world that a map shows: in round steps, so that it seldom moves; no Qt."""

import math
from bisect import bisect_left
from collections.abc import Iterable
from dataclasses import dataclass

from workbench.gui.charts.ticks import round_step

MAP_NARROWING_SHARE = 0.7
"""The content must fit into this share of a smaller step before that step is used..."""
MAP_NARROWING_DELAY_S = 2.0
"""...for this time [s]."""

MIN_MAP_REACH_M = 2.0
"""Least half of the map's shorter side [m]."""
MAP_MARGIN_FACTOR = 1.25
"""Margin around the visible content, as a factor."""
MAP_CONTENT_SHARE = 0.9
"""Share of the reach that must contain everything."""
MAP_CENTRE_DIVISOR = 8.0
"""The centre is a whole multiple of the reach divided by this."""


def round_bar(longest: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is not above a length."""
    power = 10.0 ** math.floor(math.log10(longest) + 1e-9)
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= longest * 1.000001)


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
        step = min(self._most, round_step(wanted, 1))
        if step > self.reach:
            self.reach, self._since = step, math.inf
        elif round_step(wanted / MAP_NARROWING_SHARE, 1) < self.reach:
            self._since = min(self._since, time)
            if time - self._since >= MAP_NARROWING_DELAY_S:
                self.reach, self._since = (
                    max(self._least, round_step(wanted / MAP_NARROWING_SHARE, 1)),
                    math.inf,
                )
        else:
            self._since = math.inf
        return self.reach


@dataclass(frozen=True)
class MapPlace:
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

    middle: MapPlace
    reach: float


MAP_REACHES_M = tuple(step * 10.0**power for power in range(4) for step in (1.0, 2.0, 5.0))
"""Selectable reaches of the wheel [m]."""


class SteadyFrame:
    """Chooses the visible part: it contains everything, and its size and centre move in steps."""

    def __init__(self) -> None:
        self.reset(MapPlace(0.0, 0.0))

    def reset(self, home: MapPlace, least: float = MIN_MAP_REACH_M) -> None:
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
        place = bisect_left(MAP_REACHES_M, self.frame.reach) + steps
        self._scale = SteadyScale(
            MAP_REACHES_M[
                min(max(place, MAP_REACHES_M.index(MIN_MAP_REACH_M)), len(MAP_REACHES_M) - 1)
            ]
        )

    def take(self, places: Iterable[MapPlace], time: float) -> MapFrame:
        """Return the part that shows all places.

        Args:
            places: places that must be visible.
            time: present time [s].
        """
        seen = list(places)
        east, north = [each.east for each in seen], [each.north for each in seen]
        half = max(max(east) - min(east), max(north) - min(north)) / 2.0
        reach = self._scale.take(MAP_MARGIN_FACTOR * half, time)
        middle = MapPlace((max(east) + min(east)) / 2.0, (max(north) + min(north)) / 2.0)
        now = self.frame
        room = MAP_CONTENT_SHARE * reach
        fits = reach == now.reach and all(
            abs(each.east - now.middle.east) <= room and abs(each.north - now.middle.north) <= room
            for each in seen
        )
        if not fits:
            grid = reach / MAP_CENTRE_DIVISOR
            self.frame = MapFrame(
                MapPlace(grid * round(middle.east / grid), grid * round(middle.north / grid)), reach
            )
        return self.frame
