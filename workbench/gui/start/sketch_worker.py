"""The process that draws drones, scenarios and logs for the start page: `python -m MODULE FD`."""

import contextlib
import math
import os
import sys
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.gui.recent_files import FileKind
from workbench.gui.start.sketch import Sketch, SketchPoint
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult
from workbench.plant.formats.xacro import MissingArgumentsError
from workbench.scenario.scenario import Scenario

SKETCH_NICENESS = 10
"""The flight has priority over pictures."""
MAX_PATH_POINTS = 300
"""Largest number of points of a drawn path."""
MAX_SKETCHED_LOG_BYTES = 100_000_000
"""Larger logs are not read for a picture."""
ROTOR_RADIUS_SHARE = 0.4
"""Drawn radius of a rotor of unknown size, as a share of the distance between neighbours."""
MIN_SCENE_WIDTH_M = 2.0
PATH_SIGNALS = (
    ("position_data.x", "position_data.y"),
    ("estimate.x", "estimate.y"),
    ("gps.longitude", "gps.latitude"),
)
"""Horizontal positions in a log, the first that it has."""


def sketch_of(kind: FileKind, path: Path) -> Sketch:
    """Return the drawing of a file.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    match kind:
        case FileKind.MODEL:
            return drone_sketch(path)
        case FileKind.SCENARIO:
            return scenario_sketch(path)
        case FileKind.LOG:
            return log_sketch(path)
        case _:
            raise WorkbenchError(f"{path}: there is no picture of a {kind.value}")


def sketch_or_fault(kind: FileKind, path: Path) -> Sketch:
    """Return the drawing of a file, or why it cannot be read.

    Raises:
        MissingArgumentsError: if it needs arguments, for which the app asks when it opens it.
    """
    try:
        return sketch_of(kind, path)
    except MissingArgumentsError:
        raise
    except WorkbenchError as error:
        return Sketch(fault=str(error))


def drone_sketch(path: Path) -> Sketch:
    """Return a drone from above, its nose up."""
    from workbench.plant.loading import load_vehicle  # loads Drake

    vehicle = load_vehicle(path)
    centres = [(-rotor.p_BR[1], rotor.p_BR[0]) for rotor in vehicle.rotors]
    gaps = [math.dist(a, b) for i, a in enumerate(centres) for b in centres[:i]]
    usual = ROTOR_RADIUS_SHARE * min((gap for gap in gaps if gap > 1e-6), default=1.0)
    circles = tuple(
        (x, y, rotor.propeller_radius or usual)
        for (x, y), rotor in zip(centres, vehicle.rotors, strict=True)
    )
    arms = tuple(((0.0, 0.0), centre) for centre in centres)
    said = f"{vehicle.mass:.3g} kg, {len(centres)} rotors"
    return Sketch(circles=circles, lines=arms, said=said)


def scenario_sketch(path: Path) -> Sketch:
    """Return a scenario from above, north up: obstacles, start, and the commanded path."""
    from workbench.plant.worlds.world import outlines  # loads Drake
    from workbench.scenario.configured import read_configured_world
    from workbench.scenario.scenario_file import load_scenario

    scenario = load_scenario(path)
    areas = tuple(each.at(0.0).corners for each in outlines(read_configured_world(scenario)))
    course = commanded_path(scenario)
    return Sketch(areas=areas, path=course, said=scenario.title, least_span=MIN_SCENE_WIDTH_M)


def commanded_path(scenario: Scenario) -> tuple[SketchPoint, ...]:
    """Return the horizontal path that a scenario commands, as if it were followed exactly [m]."""
    if (eight := scenario.figure_eight) is not None:
        angles = np.linspace(0.0, 2.0 * math.pi, 100)
        x = eight.center[0] + 0.5 * eight.length * np.sin(angles)
        y = eight.center[1] + 0.5 * eight.width * np.sin(2.0 * angles)
        return tuple(zip(x.tolist(), y.tolist(), strict=True))
    x, y = (scenario.start.position or (0.0, 0.0, 0.0))[:2]
    points, velocity, since = [(x, y)], scenario.start.velocity[:2], 0.0
    for action in sorted(scenario.script, key=lambda action: action.at):
        passed = action.at - since
        x, y, since = x + passed * velocity[0], y + passed * velocity[1], action.at
        points.append((x, y))
        if action.velocity is not None:
            velocity = action.velocity[:2]
        elif action.go_to is not None:
            x, y = action.go_to[:2]
            velocity = [0.0, 0.0]
            points.append((x, y))
        elif action.request is not None:
            velocity = [0.0, 0.0]
    rest = max(0.0, scenario.duration - since)
    points.append((x + rest * velocity[0], y + rest * velocity[1]))
    return tuple(points)


def log_sketch(path: Path) -> Sketch:
    """Return the path of a recorded flight from above, or else its first signal over time."""
    from workbench.logs.flight_reader import open_log

    if path.stat().st_size > MAX_SKETCHED_LOG_BYTES:
        return Sketch(said="too large to be read for a picture")
    flight = open_log(path)
    said = f"{flight.end - flight.begin:.0f} s, {flight.vehicle}"
    names = next((each for each in PATH_SIGNALS if flight.has(each)), None)
    if names is None:
        return Sketch(path=_first_curve(flight), said=said)
    east, north = (flight[name].values for name in names)
    count = min(len(east), len(north))
    shrink = math.cos(math.radians(float(north[0]))) if names[0].startswith("gps") else 1.0
    return Sketch(path=_thinned(east[:count] * shrink, north[:count]), said=said)


def _first_curve(flight: Flight) -> tuple[SketchPoint, ...]:
    """Return the first signal that varies over time, in a wide frame."""
    for series in flight.signals.values():
        values = np.asarray(series.values)
        if values.dtype.kind == "f" and len(values) > 1 and np.ptp(values[np.isfinite(values)]):
            time = np.linspace(0.0, 2.0 * float(np.nanmax(values) - np.nanmin(values)), len(values))
            return _thinned(time, values)
    return ()


def _thinned(x: np.ndarray, y: np.ndarray) -> tuple[SketchPoint, ...]:
    """Return finite points, at most `MAX_PATH_POINTS`."""
    good = np.isfinite(x) & np.isfinite(y)
    step = max(1, int(good.sum()) // MAX_PATH_POINTS)
    return tuple(zip(x[good][::step].tolist(), y[good][::step].tolist(), strict=True))


def main(connection: Connection) -> None:
    """Draw each requested file, until the app is gone."""
    os.nice(SKETCH_NICENESS)
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        while isinstance(asked := connection.recv(), WorkerRequest):
            kind, path = asked.what
            try:
                connection.send(WorkerResult(asked.number, sketch_or_fault(kind, path)))
            except (WorkbenchError, MemoryError, OSError) as error:
                connection.send(WorkerRefusal(asked.number, str(error)))


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
