"""Whether sticks count now, and if not, why: nothing starts to move that nobody has just moved."""

from workbench.control.mode import FlightMode
from workbench.link.server_messages import Hand
from workbench.live.messages import Phase
from workbench.live.view import LiveView

NO_FLIGHT = "Nothing flies: open a scenario first."
STARTING = "The flight is starting."
BROKEN = "The flight cannot go on: reset it first."
PAUSED = "The flight is paused: resume it, then the sticks count."
ON_THE_GROUND = "On the ground: take off first."
LANDING = "Landing: the sticks count again after the next take-off."
FIGURE_EIGHT = "The scenario flies its figure of eight: sticks have no say."
CENTRE = "Let go of the sticks first: they were held while they did not count."


def barrier(view: LiveView) -> str:
    """Return why sticks have no effect on a flight, "" if they have."""
    if view.phase is Phase.ENDED:
        return NO_FLIGHT
    if view.phase is Phase.BROKEN:
        return BROKEN
    if view.snapshot is None:
        return STARTING
    if view.scenario is not None and view.scenario.figure_eight:
        return FIGURE_EIGHT
    if view.phase is Phase.PAUSED:
        return PAUSED
    if view.snapshot.mode in (FlightMode.OFF, FlightMode.ARMED):
        return ON_THE_GROUND
    if view.snapshot.mode is FlightMode.LANDING:
        return LANDING
    return ""


class Gate:
    """Lets sticks through, once they were in the middle after whatever barred them."""

    def __init__(self) -> None:
        self._centre_first = False
        self._hand = Hand.NOBODY

    def close(self) -> None:
        """Ask for the middle first: the screen was left, or another flight begins."""
        self._centre_first = True

    def pass_on(self, barred: str, neutral: bool, hand: Hand) -> str:
        """Return why the sticks do not count now, "" if they do.

        Args:
            barred: why the flight does not listen to them, "" if it does.
            neutral: whether they are in the middle.
            hand: who flies; a client that was given the drone does not lose it to a held stick.
        """
        given = hand is Hand.CLIENT and self._hand is not Hand.CLIENT
        self._hand = hand
        if neutral:
            self._centre_first = False
        elif barred or given:
            self._centre_first = True
        return barred or (CENTRE if self._centre_first else "")
