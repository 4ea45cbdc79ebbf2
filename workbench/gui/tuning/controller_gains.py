"""Which of the live parameters an analyst is asked about."""

from collections.abc import Mapping

from workbench.scenario.parameters import parameters_of

CONTROLLER = frozenset(row.name for row in parameters_of("controller"))
LIMITS = frozenset(name for name in CONTROLLER if name.startswith("max_"))


def controller_gains(values: Mapping[str, float]) -> dict[str, float]:
    """Return the controller's among some values; the others are conditions of the flight."""
    return {name: value for name, value in values.items() if name in CONTROLLER}


def tunable(values: Mapping[str, float]) -> tuple[str, ...]:
    """Return the names of gains, limits of the flight left out, in the order of the values."""
    return tuple(name for name in values if name in CONTROLLER - LIMITS)
