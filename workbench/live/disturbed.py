"""Says what an action does to the drone from outside: pushes, gusts, wind and faults."""

from collections.abc import Iterator, Sequence

from workbench.scenario.faults import PARTS, TURBULENCES
from workbench.scenario.scenario import Action


def disturbed(action: Action) -> Iterator[str]:
    """Yield a sentence for each disturbance of an action; none for one that ends it."""
    push, gust = action.push, action.gust
    if push is not None and any(push.force):
        yield f"a push of {_vector(push.force)} N for {push.duration:g} s"
    if push is not None and any(push.torque):
        yield f"a torque of {_vector(push.torque)} N·m for {push.duration:g} s"
    if gust is not None and any(gust.velocity):
        yield f"a gust of {_vector(gust.velocity)} m/s for {gust.duration:g} s"
    wind = [action.set.get(f"wind_{axis}", 0.0) for axis in "xyz"]
    if any(wind):
        yield f"a wind of {_vector(wind)} m/s"
    if "turbulence" in action.set:
        speed = action.set["turbulence"]
        named = (name for name, made_by in TURBULENCES.items() if made_by == speed)
        yield f"turbulence: {next(named, f'{speed:g} m/s at 20 ft')}"
    for part in PARTS:
        if part.parameter in action.set:
            yield part.fault(action.set[part.parameter]) or f"{part.name} repaired"


def _vector(parts: Sequence[float]) -> str:
    return f"({', '.join(f'{part:.4g}' for part in parts)})"
