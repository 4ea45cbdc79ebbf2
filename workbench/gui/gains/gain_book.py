"""All values of the gains that are being tuned, side by side."""

from collections.abc import Mapping

from workbench.common.errors import WorkbenchError
from workbench.gains.difference import GainChange, diff_gains
from workbench.gui.gains.flown_values import FlownValues
from workbench.gui.gains.gain_orders import GainOrders
from workbench.gui.gains.gain_rows import flight_rows, in_profile
from workbench.gui.gains.stability import same_loops
from workbench.live.view import LiveView
from workbench.scenario.parameters import Parameter, find_parameter

Values = Mapping[str, float]


class GainBook:
    """What is proposed, ordered, flown and kept.

    Args:
        orders: that were given to the flight.

    Attributes:
        rows: of the parameter table that the flight has, in its order.
        profile_names: of those rows that belong to the vehicle.
        proposed: value by name, of all rows.
        flown: what the flight has, of all rows.
        kept: of the profile.
    """

    def __init__(self, orders: GainOrders) -> None:
        self._orders = orders
        self.rows: tuple[Parameter, ...] = ()
        self.profile_names: tuple[str, ...] = ()
        self.proposed: dict[str, float] = {}
        self.flown = FlownValues()
        self.kept: dict[str, float] = {}

    def begin(self, view: LiveView) -> None:
        """Begin with the values of a new flight; these are kept."""
        self.flown.begin(view.values, view.topics)
        self.rows = flight_rows(view.values)
        self.profile_names = tuple(row.name for row in self.rows if in_profile(row))
        self.proposed = dict(view.values)
        self.kept = self.profile(view.values)

    def check(self, name: str, value: float) -> float:
        """Return a value that a parameter may have.

        Raises:
            WorkbenchError: if the flight has no such parameter, or the table refuses the value.
        """
        if name not in self.proposed:
            raise WorkbenchError(f"nothing that flies has {name}: begin a flight first")
        return find_parameter(name).check(value)

    def profile(self, values: Values) -> dict[str, float]:
        """Return those of all values that belong to the vehicle."""
        return {name: values[name] for name in self.profile_names}

    def wanted(self, name: str) -> float:
        """Return the value that is ordered of the flight, or else flown."""
        ordered = self._orders.wanted(name)
        return self.flown.values[name] if ordered is None else ordered

    @property
    def all_wanted(self) -> dict[str, float]:
        """Values that are ordered of the flight, or else flown, of all rows."""
        return {name: self.wanted(name) for name in self.proposed}

    @property
    def unflown(self) -> tuple[str, ...]:
        """Names that are proposed with other values than are ordered or flown."""
        return tuple(name for name, value in self.proposed.items() if value != self.wanted(name))

    @property
    def tried(self) -> tuple[str, ...]:
        """Names of the profile that are flown with other values than were kept."""
        return tuple(name for name in self.profile_names if self.kept[name] != self.wanted(name))

    @property
    def proposes_kept(self) -> bool:
        """Whether what is proposed makes the loops of the kept set."""
        return same_loops(self.proposed, {**self.proposed, **self.kept})

    def difference(self) -> tuple[GainChange, ...]:
        """Return what is proposed otherwise than it was kept, from the kept values on."""
        compared = diff_gains(self.kept, self.profile(self.proposed), {})
        return tuple(each for each in compared if each.a != each.b)

    def follow(self, before: Values) -> tuple[Values, Values]:
        """Return what is flown otherwise than before, and what of it is to be shown.

        A parameter that is being tried here stays as it is proposed.
        """
        flown = self.flown.values
        changed = {name: value for name, value in flown.items() if value != before[name]}
        shown = {
            name: value
            for name, value in changed.items()
            if self._orders.wanted(name) is None and self.proposed[name] == before[name]
        }
        return changed, shown
