"""What clients of the network ask of a flight, done between its steps and answered."""

from collections.abc import Callable, Mapping

from workbench.errors import WorkbenchError, sentences
from workbench.link.authority import HOLD_AFTER, DeniedError
from workbench.link.backplane import (
    Asked,
    Command,
    FlightOperation,
    GetParameters,
    Gone,
    ReleaseControl,
    Reply,
    RequestControl,
    SetParameters,
)
from workbench.live.values import parameter_values
from workbench.parameters import checked
from workbench.scenario import Action
from workbench.session import Session
from workbench.systems.bridge import Bridge

Operation = dict[str, object]
Did = Callable[[Action, str], None]


class Desk:
    """Carries out what clients ask for.

    Args:
        session: that is flown.
        bridge: of the session.
        did: told of every action that came into force, and by whom.
    """

    def __init__(self, session: Session, bridge: Bridge, did: Did) -> None:
        self._session, self._bridge, self._did = session, bridge, did

    def answer(self, asked: Asked) -> Reply | None:
        """Do what is asked for, and return what to say; None where nothing is to be said now."""
        if isinstance(asked, Command):
            self._bridge.command(asked)  # what is wrong with it, its update finds
            return None
        if isinstance(asked, Gone):
            self._bridge.authority.gone(asked.peer)
            return None
        try:
            with sentences("the flight cannot do that"):
                operation = self._operation(asked)
        except DeniedError as error:
            operation = {"op": "nack", "code": error.code, "said": str(error)}
        except WorkbenchError as error:
            code = "bad_value" if isinstance(asked, SetParameters) else "not_now"
            operation = {"op": "nack", "code": code, "said": str(error)}
        return Reply(asked.peer, asked.id, operation)

    def _operation(
        self,
        asked: RequestControl | ReleaseControl | FlightOperation | SetParameters | GetParameters,
    ) -> Operation:
        authority, now = self._bridge.authority, self._session.time
        match asked:
            case RequestControl():
                lease = authority.request(asked.peer, asked.name, now)
                return {"op": "request_control", "lease": lease, "expires": HOLD_AFTER}
            case ReleaseControl():
                authority.release(asked.peer, asked.lease, now)
                return {"op": "release_control"}
            case GetParameters():
                return {"op": "parameters", "values": self._get(asked.names)}
            case FlightOperation():
                authority.check(asked.peer, asked.lease, now)
                self._act(Action(request=asked.what, height=asked.height), now)
                return {"op": "flight", "what": asked.what, "applied_ns": round(now * 1e9)}
            case SetParameters():
                authority.check(asked.peer, asked.lease, now)
                self._get(tuple(asked.values))  # all are there, or none is set
                self._act(Action(set=checked(asked.values)), now)
                return {"op": "parameters", "values": self._get(tuple(asked.values))}

    def _act(self, action: Action, now: float) -> None:
        self._session.act(action)
        authority = self._bridge.authority
        authority.renew(now)
        self._did(action, authority.state(now).name)

    def _get(self, names: tuple[str, ...]) -> Mapping[str, float]:
        """Return live parameters, all if no names are given.

        Raises:
            DeniedError: if this flight has not one of them.
        """
        if not names:
            return parameter_values(self._session)
        try:
            return {name: self._session.get(name) for name in names}
        except WorkbenchError as error:
            raise DeniedError("unknown_parameter", str(error)) from error
