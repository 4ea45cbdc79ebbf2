"""What is known of the stability of gains before they are flown."""

from collections.abc import Mapping

from workbench.analysis.replies import Ranges
from workbench.gui.gains.gain_rows import is_gain, is_limit
from workbench.scenario.parameters import find_parameter


def judged_names(names: Mapping[str, float]) -> list[str]:
    """Return those of the names that a loop near hover feels: gains, but no limits."""
    rows = [find_parameter(name) for name in names]
    return [row.name for row in rows if is_gain(row) and not is_limit(row)]


def same_loops(a: Mapping[str, float], b: Mapping[str, float]) -> bool:
    """Return whether two sets of values make the same loops near hover."""
    return all(a.get(name) == b.get(name) for name in judged_names({**a, **b}))


def known_stable(ranges: Ranges | None, gains: Mapping[str, float]) -> bool:
    """Return whether gains are stable by what is known, without asking anybody.

    Ranges tell of one gain that moves while the others stay. Of several that have moved, each a
    share of its way to its own end, it is taken for known where the shares add up to no more than
    1: the corner-cutting region between the ends, not the box around them.

    Args:
        ranges: with the values at which they were found, None where there are none.
        gains: all that the flight would have.
    """
    if ranges is None:
        return False
    used = 0.0
    for name in judged_names(gains):
        if name not in ranges.gains:
            return False
        used += _share(gains[name], ranges.gains[name], ranges.stable.get(name))
    return used <= 1.0


def _share(value: float, base: float, stable: tuple[float, float] | None) -> float:
    """Return which share of the way to the end of its range a gain has gone; inf beyond it."""
    far = float("inf")
    if stable is None:
        return 0.0 if value == base else far
    low, high = stable
    if not low <= base <= high:
        return far
    if not low <= value <= high:
        return far
    if value == base:
        return 0.0
    return (value - base) / ((high if value > base else low) - base)
