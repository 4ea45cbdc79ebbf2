"""A flight as it can be read between two steps."""

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram

from workbench.common.errors import WorkbenchError
from workbench.control.flight_mode import REASON_INDEX
from workbench.control.mode import FlightMode, ModeRequest, Reason
from workbench.diagram.workbench import Workbench
from workbench.parameters.parameter_table import ParameterTable, vehicle_parameters
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario
from workbench.session.flown_signals import FlownSignals
from workbench.session.live_context import LiveContext, start_position
from workbench.session.recording import Recording
from workbench.session.snapshot import Snapshot
from workbench.systems.frame_poses import FrameTransforms
from workbench.systems.sensors.readings import Reading
from workbench.systems.sensors.samples import RecordedSamples

if TYPE_CHECKING:
    from workbench.link.topics import Topic


class ObservedFlight:
    """The present of a flight, and its past; nothing here changes it.

    Attributes:
        scenario: what flies.
        vehicle: the flying vehicle.
    """

    scenario: Scenario
    vehicle: Vehicle
    _bench: Workbench
    _live: LiveContext
    _table: ParameterTable
    _earlier: FlownSignals | None

    @property
    def diagram(self) -> Diagram:
        """The diagram of the flight, for reading."""
        return self._bench.diagram

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._live.root.get_time())

    @property
    def asked(self) -> tuple[float, float, float, float]:
        """The pilot's command: velocity in W [m/s] and yaw rate [rad/s]."""
        v_x, v_y, v_z, yaw_rate, *_ = self._live.command.reference
        return v_x, v_y, v_z, yaw_rate

    @property
    def reason(self) -> Reason:
        """Why the flight mode is not the requested one, or what has failed."""
        modes = self._bench.modes
        state = modes.GetOutputPort("mode").Eval(modes.GetMyContextFromRoot(self._live.root))
        return Reason(int(state[REASON_INDEX]))

    @property
    def mode(self) -> FlightMode:
        """The flight mode."""
        return FlightMode(int(self._bench.recorder.now(self._live.root)["mode"][0]))

    @property
    def waiting_request(self) -> ModeRequest:
        """The request that the flight mode has not read yet, NONE without one."""
        command = self._live.command
        seen = self._bench.recorder.now(self._live.root)["mode"][1]
        return ModeRequest(int(command.request)) if seen < command.serial else ModeRequest.NONE

    def loop_signals(self) -> np.ndarray:
        """Return the present signals at the law's loop points (P), in their order.

        All parts of the law are evaluated, also those that run only in every n-th update.
        """
        computer = self._bench.computer
        return computer.loop_signals(self._live.context_of(computer))

    def get(self, name: str) -> float:
        """Return the present value of a live parameter."""
        return self._live.get(self._table.find(name))

    def parameters(self) -> dict[str, float]:
        """Return the live parameters that the flight has, by name."""
        values = {}
        for row in vehicle_parameters(self.vehicle, self._table):
            with suppress(WorkbenchError):  # of an inactive sensor
                values[row.name] = self.get(row.name)
        return values

    @property
    def topics(self) -> "tuple[Topic, ...]":
        """Topics that are published; none without a bridge."""
        return self._bench.topics

    def recording(self) -> Recording:
        """Return everything flown since the start."""
        flown = self._flown()
        return Recording.from_signals(self.vehicle, flown.time, flown.signals)

    def reading(self, sensor: str) -> Reading | None:
        """Return the last delivered reading of a sensor, by name or kind; None if nothing yet.

        Raises:
            WorkbenchError: if no such sensor is active in this flight.
        """
        return self._bench.sensing.find(sensor).reading(self._live.root)

    def samples(self) -> tuple[RecordedSamples, ...]:
        """Return all samples delivered since the start, if the scenario keeps them."""
        kept = zip(self._bench.sensing.kept, self._flown().samples, strict=True)
        return tuple(mounted.samples(rows) for mounted, rows in kept)

    def snapshot(self) -> Snapshot:
        """Return the present as a frozen copy."""
        start = start_position(self.scenario.start, self.vehicle)
        return self._live.snapshot(start)

    def draw(self) -> None:
        """Draw the present in Meshcat, if the session draws."""
        visualizer = self._bench.visualizer
        if visualizer is not None:
            visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(self._live.root))

    def state(self) -> np.ndarray:
        """Return the present state of the body (13): q_WB, p_WB, w_WB and v_WB, SI units."""
        return self._bench.airframe.body_state(self._live.root)

    def free_way(self, direction_W: Sequence[float], most: float) -> tuple[float, str]:
        """Return how far the drone can fly straight ahead before it may touch something [m].

        Args:
            direction_W: unit vector in W.
            most: largest distance [m].

        Returns:
            The free distance, at most `most`, and the name of the obstacle there, or "".
        """
        obstacles, found = self._bench.obstacles, (most, "")
        if obstacles is not None:
            found = obstacles.free_way(self._live.root, direction_W, most)
        down = -direction_W[2]
        if down > 0.0:
            height = float(self.state()[6]) - self.vehicle.ground_clearance
            found = min(found, (max(0.0, height) / down, "the ground"))
        return found

    def pose(self, a: str, b: str) -> RigidTransform:
        """Return X_AB, the present pose of frame B in frame A; `workbench frames` lists them.

        Raises:
            WorkbenchError: if a frame does not exist.
        """
        frames = self._bench.frames
        return frames.pose(frames.GetMyContextFromRoot(self._live.root), a, b)

    def frames(self) -> FrameTransforms:
        """Return the present pose of every frame in its parent frame."""
        frames = self._bench.frames
        return frames.transforms(frames.GetMyContextFromRoot(self._live.root))

    def _flown(self) -> FlownSignals:
        """Return everything that was recorded since the start."""
        rows = [each.kept_rows(self._live.root) for each in self._bench.sensing.kept]
        now = FlownSignals(*self._live.recorded(), rows)
        return self._earlier.followed_by(now) if self._earlier else now
