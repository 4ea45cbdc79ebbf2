"""Gains of a law that make the same loops as those of another, saved and printed."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.printing import pick, print_table

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.translate.loop_difference import LoopDifference
    from workbench.design.translate.translation import Translation
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario.scenario import Scenario


@dataclasses.dataclass(frozen=True)
class TranslatedGains:
    """Gains of a law that make the same loops as those of another.

    Attributes:
        scenario: the flight with the new law.
        vehicle: theirs.
        laws: the old one, and the new one.
        found: the gains, and what is not exact.
        wanted: values from --set, which replace those translated, by name.
        flown: differences of the loops as both laws fly.
        alone: and without periods and filters of their own.
    """

    scenario: "Scenario"
    vehicle: "Vehicle"
    laws: "tuple[Controller, Controller]"
    found: "Translation"
    wanted: dict[str, float]
    flown: "tuple[LoopDifference, ...]"
    alone: "tuple[LoopDifference, ...]"

    @property
    def values(self) -> dict[str, float]:
        """Values of all parameters of the new law."""
        return {**self.found.values, **self.wanted}

    def result(self) -> dict[str, Any]:
        """Return the translation for JSON."""
        return {
            "from": self.laws[0].name,
            "to": self.laws[1].name,
            **pick(self.found, "gains lost remarks"),
            "set": self.wanted,
            "loops": {"flown": self.flown, "gains_alone": self.alone},
        }

    def save(self, path: Path, origin: str = "") -> None:
        """Save the gains of the new law in a gain file."""
        told = f"translated from {self.laws[0].name} for {self.vehicle.name}"
        origin = f"{origin}, {told}" if origin else told
        save_gain_values(path, self.vehicle, self.values, origin, self.laws[1])

    def show(self) -> None:
        """Print the gains, the loops and inexact parts."""
        old, new = self.laws
        title = f"{self.vehicle.name}: gains of {old.name}, translated to {new.name}"
        _print_translation(title, self.found, self.flown, self.alone)
        for name, value in self.wanted.items():
            print(f"set in place of what is translated: {name} {value:g}")


def save_gain_values(
    path: Path,
    vehicle: "Vehicle",
    values: Mapping[str, float],
    origin: str,
    law: "Controller",
) -> None:
    """Save gains of a law in a gain file."""
    from workbench.gains.gain_choice import make_profile
    from workbench.gains.gains import save_gains

    save_gains(path, make_profile(vehicle, values, origin, law), law)


def translated_gains(
    scenario: "Scenario",
    values: Mapping[str, float],
    target: "Controller",
    later: Mapping[str, float],
) -> TranslatedGains:
    """Return gains translated to another law.

    Args:
        scenario: the flight with the law of the given gains.
        values: of all parameters of that law.
        target: the other law.
        later: values of its parameters, which replace those translated.
    """
    from workbench.design.linear.study import LinearStudy
    from workbench.design.translate.loop_difference import gains_alone, loop_differences
    from workbench.design.translate.translation import translate
    from workbench.gains.gain_choice import flight_gains

    old = LinearStudy(scenario)
    bare = dataclasses.replace(scenario.vehicle, gains="")
    new = old.like(dataclasses.replace(old.scenario, controller=target.reference, vehicle=bare))
    own = flight_gains(old.vehicle, "", later, target)
    found = translate(old, new, values, dict(new.gains))
    flown = loop_differences(old, new, values, found.values)
    alone = gains_alone(old, new, values, found.values)
    rows = target.table
    wanted = {row.name: own[row.name] for name in later for row in rows.sets(name)}
    laws = (old.controller, target)
    return TranslatedGains(new.scenario, old.vehicle, laws, found, wanted, flown, alone)


def _print_translation(
    title: str,
    found: "Translation",
    flown: "tuple[LoopDifference, ...]",
    alone: "tuple[LoopDifference, ...]",
) -> None:
    """Print the gains, the loops and inexact parts."""
    print(title)
    rows = [(each.name, f"{each.value:.5g}", each.unit, each.said) for each in found.gains]
    print_table([("gain", "value", "", ""), *rows], left=(0, 2, 3))
    print("\nloops at the plant's input, difference up to the crossover:")
    lines = [("loop", "crossover [rad/s]", "new", "as flown", "gains alone", "")]
    for one, other in zip(flown, alone, strict=True):
        lost = found.lost_in(one.channel)
        why = "" if not lost and found.exact else lost[0] if lost else "see the notes"
        lines.append(
            (
                one.channel,
                f"{one.crossover:.3g}",
                f"{one.other:.3g}",
                f"{100.0 * one.largest:.2g} %",
                f"{100.0 * other.largest:.2g} %",
                why,
            )
        )
    print_table(lines, left=(0, 5))
    print("gains alone: both at the same control period, without the laws' own filters")
    for each in dict.fromkeys(found.lost):
        print(f"left out: {each.axis}: {each.said}")
    for remark in found.remarks:
        print(f"note: {remark}")
