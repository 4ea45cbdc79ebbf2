"""Extensions: what installed packages add to the workbench, found by their entry points.

A package adds a thing by one line of its `pyproject.toml`, as in

    [project.entry-points."workbench.commands"]
    gateway = "workbench.extras.gateways.command:add_parser"

The shipped extras use the same groups as any other package; see docs/extending.md. The core knows
the groups and what their objects must be, and never who is in them.
"""

from enum import StrEnum
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.common.errors import WorkbenchError, unknown_name

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Kind = TypeVar("Kind")
"""The type of the objects of a group."""


class ExtensionGroup(StrEnum):
    """The groups of entry points, and what the object of an entry is."""

    COMMANDS = "workbench.commands"
    """A function `add_parser(commands)` that adds the command of the entry's name."""
    LAWS = "workbench.laws"
    """A module that is the file of a control law, see docs/controllers.md."""
    LAW_PROGRAMS = "workbench.law_programs"
    """The same, of a law that a separate program runs: it has `program` in place of `update`."""
    LAW_FORMS = "workbench.law_forms"
    """A `Form` (design/translate/forms.py): what the gains of the law of the entry's name mean."""
    GAIN_FORMATS = "workbench.gain_formats"
    """A `GainFormat` (gains/formats.py): gains in the files of the firmware of the entry's name."""
    FORMATS = "workbench.formats"
    """A `DescriptionFormat` (`plant/readers.py`): a reader of descriptions."""
    ROTOR_DIALECTS = "workbench.rotor_dialects"
    """A `RotorDialect` (`plant/readers.py`): a way to write rotors in a description."""
    WORLDS = "workbench.worlds"
    """A `WorldFormat` (`plant/readers.py`): a reader of world files."""
    CARDS = "workbench.cards"
    """A `CardRow` of `gui/tuning/added_cards.py`: a card of the Tuning screen."""
    LOG_READERS = "workbench.log_readers"
    """A `LogReader` (`logs/readers/log_reader.py`), a format of other programs, or a tuple."""
    SENSORS = "workbench.sensors"
    """A `MeasuringSensor` (`systems/sensors/measuring.py`): the class of the entry's kind."""
    SIGNALS = "workbench.signals"
    """A `Signal` (`link/signal.py`): a published quantity, as of a sensor of another package."""
    CHARTS = "workbench.charts"
    """A `ChartKind` (`gui/charts/chart_kind.py`): a kind of chart of the name of the entry."""

    @property
    def noun(self) -> str:
        """What one of the group is called in a message."""
        return self.value.removeprefix("workbench.").removesuffix("s").replace("_", " ")


@cache
def find_extensions(group: ExtensionGroup) -> dict[str, "EntryPoint"]:
    """Return the entries of a group by name, in alphabetical order; nothing of them is imported."""
    from importlib.metadata import entry_points  # takes 70 ms, which few commands need

    return {each.name: each for each in sorted(entry_points(group=group), key=lambda e: e.name)}


def package_of(entry: "EntryPoint") -> str:
    """Return the name of the package that an entry is of, as pip has it."""
    return entry.dist.name if entry.dist else "an unknown package"


def is_complete(entry: "EntryPoint") -> bool:
    """Return whether the module of an entry can be imported."""
    try:
        return find_spec(entry.module) is not None
    except ModuleNotFoundError:  # of a package above it
        return False


def complete_extensions(group: ExtensionGroup) -> tuple[str, ...]:
    """Return the names of the entries whose modules can be imported; nothing is imported."""
    return tuple(name for name, entry in find_extensions(group).items() if is_complete(entry))


def load_extension(group: ExtensionGroup, name: str) -> Any:
    """Return the object of an entry.

    Raises:
        WorkbenchError: if there is none of that name, or its package cannot be imported.
    """
    known = find_extensions(group)
    if name not in known:
        raise unknown_name(group.noun, name, known)
    entry = known[name]
    try:
        return entry.load()
    except (ImportError, AttributeError) as error:
        raise WorkbenchError(
            f"the {group.noun} '{name}' is in {entry.module} of the package {package_of(entry)}, "
            f"which cannot be loaded ({error}): install the package again, or remove it"
        ) from error


@cache
def load_extensions(group: ExtensionGroup, kind: type[Kind]) -> dict[str, Kind]:
    """Return the objects of a group by name, without those that cannot be loaded.

    A package whose module is gone is left out. One that fails while it is imported, or whose object
    is of another type than `kind`, is left out with a warning.
    """
    import logging

    found: dict[str, Kind] = {}
    for name in complete_extensions(group):
        try:
            thing = load_extension(group, name)
        except WorkbenchError as error:
            logging.getLogger("workbench").warning("%s", error)
            continue
        if isinstance(thing, kind):
            found[name] = thing
        else:
            warn_left_out(group, name, f"is no {kind.__name__}")
    return found


def warn_left_out(group: ExtensionGroup, name: str, reason: str) -> None:
    """Log that the object of an entry is left out."""
    import logging

    value = find_extensions(group)[name].value
    text = f"the {group.noun} '{name}': {value} {reason}; left out"
    logging.getLogger("workbench").warning(text)
