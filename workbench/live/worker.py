"""The live flight's process: `python -m workbench.live.worker FD`, a socket to the caller.

It exits on request, or when its caller exits.
"""

import gc
import logging
import math
import os
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from multiprocessing.connection import Connection

from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.ipc.send_queue import LogSender, SendQueue
from workbench.live.messages import FlightFailure, FlightNotice, FlightStart, ViewChange
from workbench.plant.formats.xacro import MissingArgumentsError

LAST_SEND_TIMEOUT_S = 2.0
"""Time limit for sending the last messages [s]."""


def main(connection: Connection) -> int:
    """Fly according to the first message, and return the exit code."""
    caller = os.getppid()
    send_queue = SendQueue(connection)
    try:
        send_queue.post(_start_progress("loading Drake"))
        begin = _first_message(connection)
        if begin is not None:
            with ExitStack() as opened:
                _fly_session(begin, connection, send_queue, lambda: os.getppid() == caller, opened)
    except MissingArgumentsError as error:
        send_queue.post(FlightFailure(str(error), error.arguments))
    except WorkbenchError as error:
        send_queue.post(FlightFailure(str(error)))
    except Exception as error:  # a programming error: report it to the caller
        send_queue.post(
            FlightFailure(f"the flight's process failed: {type(error).__name__}: {error}")
        )
        return 1
    finally:
        send_queue.close(LAST_SEND_TIMEOUT_S)
    return 0


def _start_progress(said: str) -> ViewChange:
    """Return a callback that reports progress until the flight begins."""
    return ViewChange({"said": said})


def _first_message(connection: Connection) -> FlightStart | None:
    """Return the first message, None if the caller has changed its mind."""
    try:
        begin = connection.recv()
    except (EOFError, OSError):
        return None
    return begin if isinstance(begin, FlightStart) else None


def _fly_session(
    begin: FlightStart,
    connection: Connection,
    send_queue: SendQueue,
    wanted: Callable[[], bool],
    opened: ExitStack,
) -> None:
    """Build the session and fly it.

    Raises:
        WorkbenchError: if it cannot be built.
    """
    from pydrake.geometry import Meshcat, MeshcatParams

    from workbench.live.choice import Choice
    from workbench.live.flying import FlightLoop
    from workbench.live.picture import LivePicture
    from workbench.live.stream import RecordStream
    from workbench.plant.home import DEFAULT_HOME
    from workbench.plant.worlds.world import outlines
    from workbench.scenario.scenario_file import without_arrays
    from workbench.session.session import Session
    from workbench.systems.bridge import Bridge

    gc.freeze()  # a search for garbage in all modules would stop the flight for 15 ms
    send_queue.post(_start_progress("building the diagram"))
    logger = logging.getLogger("workbench")
    logger.setLevel(logging.INFO)
    logger.addHandler(LogSender(send_queue, FlightNotice))
    progress = logging.getLogger(PROGRESS_LOGGER)
    progress.addHandler(LogSender(send_queue, _start_progress))
    progress.propagate = False
    with drake_error_sentences("the flight could not be built"):
        # by default Meshcat would show the flight to the whole network
        params = MeshcatParams(host="localhost", show_stats_plot=False)
        meshcat = Meshcat(params) if begin.draw else None
        bridge = Bridge()
        wanted_flight = begin.scenario
        scenario = wanted_flight.load() if isinstance(wanted_flight, Choice) else wanted_flight
        # the stream has every sample; a recording's arrays would fill the memory in hours
        flown = without_arrays(scenario) if begin.stream else scenario
        session = Session(flown, begin.settings, meshcat, bridge, picture_period=math.inf)
        opened.enter_context(session.programs())
        law = session.controller
        send_queue.post(_start_progress("flying the first step"))
        # It loads compiled code, and a camera's first picture is slow.
        session.tick(session.scenario.rates.control_period)
        session.reset()
    begins = {
        "vehicle": session.vehicle,
        "values": session.parameters(),
        "url": meshcat.web_url() if meshcat else "",
        "scenario": scenario,
        "topics": session.topics,
        "controller": law,
        "outlines": outlines(session.world),
        "home": session.world.home or DEFAULT_HOME,
    }
    send_queue.post(ViewChange(begins))
    stream = RecordStream(send_queue if begin.stream else None)
    flying = FlightLoop(
        session,
        bridge,
        begin.settings,
        send_queue,
        time.perf_counter,
        stream,
        begin.watch,
    )
    if meshcat:
        scan = partial(session.reading, "lidar")
        picture = LivePicture(meshcat, session.draw, session.vehicle, time.perf_counter, scan)
        flying.shown, flying.foresee = picture.show, picture.foresee
    flying.run(connection, wanted)


if __name__ == "__main__":
    # all messages are sent and nothing is left to write: Drake's slow teardown is unnecessary
    os._exit(main(Connection(int(sys.argv[1]))))
