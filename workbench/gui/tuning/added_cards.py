"""Cards that packages add to the Tuning screen."""

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from workbench.common.extensions import ExtensionGroup, load_extensions
from workbench.gui.tuning.card import TuningCard

if TYPE_CHECKING:
    from workbench.gui.tuning.designs import Designs
    from workbench.gui.tuning.trial import TuningTrial
    from workbench.gui.workspace import Workspace


class AddedCard(TuningCard):
    """A card of another package."""

    def begin(self) -> None:
        """Clear the answers: another flight or another controller begins."""


class CardRow(NamedTuple):
    """A card, as an entry of `workbench.cards` names it.

    Attributes:
        title: title of its tab.
        make: returns it, for the services of the app, the gains that are being tried, and the
            designs to compare.
        log_button: text of a button beside an opened log that shows the card; "" for none.
        log_help: help of that button.
    """

    title: str
    make: "Callable[[Workspace, TuningTrial, Designs], AddedCard]"
    log_button: str = ""
    log_help: str = ""


def added_cards() -> tuple[CardRow, ...]:
    """Return the cards that packages add; one that cannot be loaded is left out with a warning."""
    return tuple(load_extensions(ExtensionGroup.CARDS, CardRow).values())
