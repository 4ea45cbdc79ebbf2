"""The control law of a live flight: its file, and how another law takes over."""

from collections.abc import Callable
from dataclasses import replace

from workbench.common.errors import WorkbenchError
from workbench.common.own_file import read_user_file
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller, with_estimator
from workbench.ipc.send_queue import SendQueue
from workbench.live.announcer import INFORMATION_SEVERITY
from workbench.live.messages import ControllerChange, FlightNotice
from workbench.live.network import FlightNetwork
from workbench.scenario.scenario import Action
from workbench.scenario.scenario_check import check_scenario
from workbench.session.session import Session

LAW_FILE_PERIOD_S = 0.25
"""Period between checks of the controller's file [s of wall]."""


class FlyingLaw:
    """Lets laws take over, and tells the caller and all clients which one flies.

    Args:
        session: the flown session.
        network: network of the flight.
        send_queue: takes what the caller is told.
        now: returns the wall time [s].
        watch: whether the law's file is loaded again whenever it is saved.

    Attributes:
        law: the law that was told last.
    """

    def __init__(
        self,
        session: Session,
        network: FlightNetwork,
        send_queue: SendQueue,
        now: Callable[[], float],
        watch: bool,
    ) -> None:
        self._session, self._network, self._send_queue = session, network, send_queue
        self._now, self._watch = now, watch
        self._fly(session.controller)

    def edited(self) -> bool:
        """Return whether its file was saved with another text, once for each text.

        It polls the file: editors write in place, or replace the file.
        """
        now = self._now()
        if not self._watch or self.law.shipped or now < self._due:
            return False
        self._due = now + LAW_FILE_PERIOD_S
        state = self._file_state()
        if state in (None, self._state):  # briefly absent, as with some editors
            return False
        self._state = state
        try:
            text = read_user_file(self.law.file, "controller")
        except WorkbenchError:
            return True  # the loader reports what is wrong
        changed, self._text = text != self._text, text
        return changed and bool(text)  # an empty file is about to be written

    def take_over(self, name_or_path: str) -> None:
        """Switch to another law from now on.

        Raises:
            WorkbenchError: if it cannot be loaded, or cannot take over.
        """
        session = self._session
        law = with_estimator(load_controller(name_or_path), session.controller.estimator)
        # a script that sets missing parameters would break the flight later, or after a reset
        check_scenario(replace(session.flown_scenario, controller=name_or_path))
        action = Action(controller=name_or_path)
        session.do(action)
        # with all gains: another machine that repeats the log may not have the gain file
        gains = {row.name: session.get(row.name) for row in law.parameters}
        self._network.did(replace(action, set=gains))
        if law is self.law:
            self.tell(f"{law.name} flies already, with the same text")
        self.show()

    def show(self) -> None:
        """Tell of a new law: of an edit, of the script, or of a reset."""
        law, session = self._session.controller, self._session
        if law is self.law:
            return
        same_rows = law.table.rows == self.law.table.rows
        self._fly(law)
        flown = session.flown_scenario
        values = session.parameters()
        self._send_queue.post(ControllerChange(law, values, flown.controller, flown.vehicle.gains))
        self.tell(f"{law.name} has taken over at {session.time:.2f} s")
        self._network.taken_over(same_rows)

    def tell(self, said: str, severity: int = INFORMATION_SEVERITY) -> None:
        """Report an event to the caller and to all clients."""
        self._send_queue.post(FlightNotice(said))
        self._network.event(said, severity)

    def _fly(self, law: Controller) -> None:
        """Watch the file of a law from now on."""
        self.law, self._text, self._due = law, law.text, self._now()
        self._state = self._file_state()

    def _file_state(self) -> tuple[int, int, int] | None:
        try:
            state = self.law.file.stat()
        except OSError:
            return None
        return state.st_mtime_ns, state.st_size, state.st_ino
