"""A controller whose gains are scheduled over a measured quantity."""

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.common.own_file import check_names, user_record_type
from workbench.control.controller import COMMON_PARAMETERS, Controller
from workbench.control.guidance import Gains, KnownVehicle
from workbench.control.schedule import parse_schedule, with_label

if TYPE_CHECKING:
    from workbench.plant.vehicle import Vehicle


@lru_cache(maxsize=32)
def scheduled_controller(controller: Controller, label: str) -> Controller:
    """Return a controller with sets of its gains over a quantity; limits have one value.

    Raises:
        WorkbenchError: if the label is not a schedule, or the gains are already scheduled, or
            cannot change in flight.
    """
    schedule = parse_schedule(label)
    if controller.schedule:
        raise WorkbenchError(
            f"{controller.name}@{label}: gains are scheduled over one quantity: leave one out"
        )
    if controller.program:
        raise WorkbenchError(
            f"{controller.name}@{label}: its gains are in a separate process, and cannot be "
            "scheduled: leave out the schedule"
        )
    if not controller.compiles:
        raise WorkbenchError(
            f"{controller.file}: is made for its gains once, so they cannot be scheduled: give the "
            "system an input for what they depend on"
        )
    common = [row.name for row in COMMON_PARAMETERS]
    own = [row for row in controller.parameters if row.name not in common]
    rows = [
        replace(row, name=name, help=f"{row.help}, {schedule.where(number)}")
        for row in own
        for number, name in enumerate(schedule.names(row.name))
    ]
    fields = [row.name for row in own]

    def all_sets(names: Iterable[str]) -> tuple[str, ...]:
        """Return names of parameters, each in all of its sets."""
        return tuple(
            each for name in names for each in (schedule.names(name) if name in fields else (name,))
        )

    def rule(vehicle: "Vehicle") -> dict[str, float]:
        values = controller.rule(vehicle) if controller.rule else {}
        return {each: value for name, value in values.items() for each in all_sets([name])}

    def design(vehicle: KnownVehicle, g: Gains, dt: float) -> list[float]:
        sets = [
            controller.design_with(
                [getattr(g, name + suffix) for name in fields]
                + [getattr(g, name) for name in common],
                vehicle,
                dt,
            )
            for suffix in schedule.suffixes
        ]
        return [x for designed in zip(*sets, strict=True) for x in designed]

    made = replace(
        controller,
        name=with_label(controller.name, schedule.label),
        parameters=(*rows, *(row for row in controller.parameters if row.name in common)),
        loops=tuple(replace(loop, gains=all_sets(loop.gains)) for loop in controller.loops),
        rule=rule if controller.rule else None,
        designed=tuple(each for name in controller.designed for each in schedule.names(name)),
        design=design if controller.design else None,
        schedule=schedule,
    )
    gains = user_record_type(f"Gains_{controller.key}", controller.gain_names)
    law = schedule.update(controller.update, gains, [*fields, *controller.designed], made.key)
    check_names(controller.file, "parameter", made.gain_names)
    return replace(made, update=law)
