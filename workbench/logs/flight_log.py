"""Write the log of a flight during the flight; an error of the file never ends the flight."""

import json
import logging
import struct
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import MCAP0_MAGIC

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.link.backplane import Published, Sampled
from workbench.link.ros_messages.cdr import codec
from workbench.link.ros_messages.conversion import conversion
from workbench.link.ros_messages.library import schema_text
from workbench.link.ros_messages.making import ROS_WORLD_FRAME, header
from workbench.link.ros_messages.namespace import in_namespace, ros_namespace
from workbench.link.signal import RosChannel
from workbench.link.topics import Topic
from workbench.logs.contents import (
    ACTIONS_CHANNEL,
    CONTROLLER_METADATA,
    ESTIMATOR_ATTACHMENT,
    ESTIMATOR_METADATA,
    FLIGHT_METADATA,
    GAINS_ATTACHMENT,
    JOINTS_METADATA,
    LAW_ATTACHMENT,
    LAW_MEDIA_TYPE,
    SCENARIO_ATTACHMENT,
    SETTINGS_METADATA,
    STATE_CHANNEL,
    TOPICS_ATTACHMENT,
    VERSIONS_METADATA,
    action_text,
    law_attachment_name,
    logged_gains_text,
    scenario_text,
    software_versions,
)
from workbench.logs.mcap_writer import McapWriter
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

LOG_NS_PER_S = 1e9
"""Nanoseconds in a second."""
FILE_CHECK_PERIOD_S = 1.0
"""Period between checks that the file is still in its place [s]."""
_LOG_WRITE_ERRORS = (OSError, ValueError, KeyError, TypeError, OverflowError, struct.error)
"""Errors from writing, such as a full disk, or a payload that does not fit its topic."""


class FlightLog:
    """The log of one flight, from its start on.

    A chunk of some 128 kB is written as soon as it is full. So a killed process leaves a file that
    is readable except for the last chunk.

    Args:
        path: the file; an older log of that name is overwritten, any other file is not.
        topics: the published ones.
        scenario: the one flown.
        settings: parameter values that replace those of the scenario.
        values: all parameter values at the start.
        vehicle: its name.
        controller: the one that flies; None for that of the scenario, from its present file.
        joints: see `Vehicle.published_joint_units`.

    Attributes:
        path: the file.
        said: why the log ended before it was closed, else ""; it is also logged once.

    Raises:
        WorkbenchError: if the file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        topics: Sequence[Topic],
        scenario: Scenario,
        settings: Mapping[str, float],
        values: Mapping[str, float],
        vehicle: str,
        controller: Controller | None = None,
        joints: Mapping[str, str] | None = None,
    ) -> None:
        law = controller or flown_controller(scenario)
        self.path = path
        self.said = ""
        self._step = scenario.rates.physics_step
        self._state, self._action = (
            codec(STATE_CHANNEL.type).encode,
            codec(ACTIONS_CHANNEL.type).encode,
        )
        self._last_ns = 0
        self._look_due = time.monotonic() + FILE_CHECK_PERIOD_S
        self._open = True
        found = software_versions()
        _refuse_others(path)
        try:
            self._writer = McapWriter(path, f"workbench {found['workbench']}")
        except OSError as error:
            raise _not_written(path, error) from error
        try:
            if joints:
                self._writer.add_metadata(JOINTS_METADATA, dict(joints))
            self._begin(topics, scenario, settings, values, vehicle, law, found)
        except BaseException as error:
            self._writer.discard()
            if isinstance(error, OSError):
                raise _not_written(path, error) from error
            raise

    def write(self, sampled: Sampled) -> None:
        """Write the topics published at one time, and the exact state."""
        if self._open:
            try:
                self._publish(sampled.published)
                self._keep(sampled)
            except _LOG_WRITE_ERRORS as error:
                self._end(error)

    def publish(self, published: Published) -> None:
        """Write other published topics, such as events."""
        if self._open:
            try:
                self._publish(published)
            except _LOG_WRITE_ERRORS as error:
                self._end(error)

    def act(self, at: float, action: Action, by: str, law: Controller | None = None) -> None:
        """Write an action.

        Args:
            at: a time of whole physics steps [s].
            action: the action; its own `at` is ignored.
            by: operator, a client's name, link, ...
            law: the one that flies then; its text is written if it takes over and is not shipped.
        """
        if not self._open:
            return
        if action.controller is not None and law is not None and not law.shipped:
            action = replace(action, controller=law_attachment_name(law))
            self._attach_law(law)
        t_ns = round(at * LOG_NS_PER_S)
        values = {
            "header": header(t_ns, ""),
            "step": round(at / self._step),
            "by": by,
            "action": action_text(action),
        }
        try:
            self._writer.message(self._action_channel, t_ns, time.time_ns(), self._action(values))
        except _LOG_WRITE_ERRORS as error:
            self._end(error)

    def _attach_law(self, law: Controller) -> None:
        try:
            now = time.time_ns()
            self._writer.add_attachment(
                now, now, law_attachment_name(law), LAW_MEDIA_TYPE, law.text.encode()
            )
        except _LOG_WRITE_ERRORS as error:
            self._end(error)

    def look(self) -> None:
        """End the log if its file was moved, deleted or shortened; checks at most once a second.

        Writing to such a file loses data without any error.
        """
        now = time.monotonic()
        if self._open and now >= self._look_due:
            self._look_due = now + FILE_CHECK_PERIOD_S
            self._check_place()

    def close(self) -> None:
        """End the file; nothing more is written. `said` states the reason if it is incomplete."""
        self._check_place()
        if self._open:
            try:
                self._writer.finish()
            except _LOG_WRITE_ERRORS as error:
                self._end(error)
            self._open = False

    def _begin(
        self,
        topics: Sequence[Topic],
        scenario: Scenario,
        settings: Mapping[str, float],
        values: Mapping[str, float],
        vehicle: str,
        law: Controller,
        found: Mapping[str, str],
    ) -> None:
        """Write all data known before the flight."""
        now, writer = time.time_ns(), self._writer
        flight = {"vehicle": vehicle, "physics_step": repr(self._step), "begun_ns": str(now)}
        writer.add_metadata(FLIGHT_METADATA, flight)
        writer.add_metadata(VERSIONS_METADATA, found)
        writer.add_metadata(
            SETTINGS_METADATA, {name: repr(value) for name, value in settings.items()}
        )
        whose = {"name": law.name, "file": str(law.file), "sha256": law.digest}
        writer.add_metadata(CONTROLLER_METADATA, whose)
        attach = partial(writer.add_attachment, now, now)
        attach(LAW_ATTACHMENT, LAW_MEDIA_TYPE, law.text.encode())
        if law.estimator:
            own = law.estimator
            whose = {"name": own.name, "file": str(own.file), "sha256": own.digest}
            writer.add_metadata(ESTIMATOR_METADATA, whose)
            attach(ESTIMATOR_ATTACHMENT, LAW_MEDIA_TYPE, own.text.encode())
        attach(SCENARIO_ATTACHMENT, "application/yaml", scenario_text(scenario).encode())
        gains = logged_gains_text(vehicle, values, law.name).encode()
        attach(GAINS_ATTACHMENT, "application/yaml", gains)
        definitions = json.dumps([topic.definition() for topic in topics], indent=1)
        attach(TOPICS_ATTACHMENT, "application/json", definitions.encode())
        schemas: dict[str, int] = {}
        namespace = ros_namespace(vehicle)

        def add(channel: RosChannel) -> int:
            if channel.type not in schemas:
                text = schema_text(channel.type).encode()
                schemas[channel.type] = writer.register_schema(
                    channel.type, SchemaEncoding.ROS2, text
                )
            return writer.register_channel(
                in_namespace(channel.topic, namespace),
                MessageEncoding.CDR,
                schemas[channel.type],
            )

        self._state_channel, self._action_channel = add(STATE_CHANNEL), add(ACTIONS_CHANNEL)
        # The log uses the parts of a conversion separately, as it writes thousands of messages a
        # second: for each message a factory, an encoder and a channel.
        self._topics = {
            topic.id: (
                becomes := conversion(topic),
                tuple(
                    (make, codec(channel.type).encode, add(channel))
                    for channel, make in becomes.made
                ),
            )
            for topic in topics
        }

    def _check_place(self) -> None:
        """End the log if its file is no longer in its place or as written; complete a moved one."""
        if not self._open:
            return
        try:
            self._writer.check_size()
        except OSError as error:
            self._end(error)
            return
        if self._writer.is_in_place():
            return
        self._open = False
        try:
            self._writer.finish()
        except _LOG_WRITE_ERRORS as error:
            self._end(error)
        else:
            self._tell("the file was moved or deleted")

    def _publish(self, published: Published) -> None:
        """Write the messages of topics."""
        t_ns, wall_ns, write = published.t_ns, published.wall_ns, self._writer.message
        for number, payload in published.payloads:
            becomes, parts = self._topics[number]
            values = becomes.read(payload)
            for make, encode, channel in parts:
                write(channel, t_ns, wall_ns, encode(make(t_ns, values)))

    def _keep(self, sampled: Sampled) -> None:
        """Write the exact state."""
        t_ns, wall_ns = sampled.published.t_ns, sampled.published.wall_ns
        state = sampled.state
        exact = {
            "header": header(t_ns, ROS_WORLD_FRAME),
            "q_wb": state[0:4],
            "p_wb": state[4:7],
            "w_wb": state[7:10],
            "v_wb": state[10:13],
        }
        self._writer.message(self._state_channel, t_ns, wall_ns, self._state(exact))
        self._last_ns = t_ns

    def _end(self, error: Exception) -> None:
        """End the log, not the flight, and log this once."""
        self._open = False
        reason = getattr(error, "strerror", None) or str(error)
        try:
            self._writer.give_up()
        except OSError as failure:
            reason = f"{reason}; {failure.strerror}"
        self._tell(reason)

    def _tell(self, reason: str) -> None:
        self.said = (
            f"{self.path}: the log ends at {self._last_ns / LOG_NS_PER_S:.3f} s: {reason}; "
            "the flight continues without it"
        )
        logging.getLogger("workbench").warning("%s", self.said)


def _refuse_others(path: Path) -> None:
    """Check that no file other than a log is overwritten.

    Raises:
        WorkbenchError: if it would be.
    """
    try:
        if not path.exists():
            return
        if not path.is_file():
            what = "a folder" if path.is_dir() else "not a plain file"
            raise WorkbenchError(f"{path}: is {what}: give the log a file of its own")
        with path.open("rb") as file:
            head = file.read(len(MCAP0_MAGIC))
    except OSError as error:
        raise _not_written(path, error) from error
    if not MCAP0_MAGIC.startswith(head):
        raise WorkbenchError(f"{path}: is not a log, and is not overwritten: name another file")


def _not_written(path: Path, error: OSError) -> WorkbenchError:
    if isinstance(error, FileNotFoundError):
        return WorkbenchError(f"{path}: there is no folder {path.parent}: make it first")
    reason = error.strerror or str(error)
    return WorkbenchError(f"{path}: cannot be written: {reason}; name another place")


class LoggedFlight:
    """Flies a scenario and logs it.

    Args:
        path: of the log.
        scenario: what to fly.
        settings: parameter values that override those of the scenario's gains.

    Attributes:
        session: the one flown.

    Raises:
        WorkbenchError: if the scenario cannot be built, or the log cannot be written.
    """

    def __init__(self, path: Path | str, scenario: Scenario, settings: Mapping[str, float]) -> None:
        self.session = Session(scenario, settings, bridge=Bridge())
        self._log = FlightLog(
            Path(path),
            self.session.topics,
            scenario,
            settings,
            self.session.parameters(),
            self.session.vehicle.name,
            self.session.controller,
            self.session.vehicle.published_joint_units,
        )

    @property
    def said(self) -> str:
        """Why the log is incomplete, else ""."""
        return self._log.said

    def run(self, progress: Callable[[float], None]) -> None:
        """Fly to the end of the scenario, calling `progress` with the flown share, 0 .. 1.

        Raises:
            FlightBrokenError: if the simulation cannot continue; the log ends there.
        """

        def keep(share: float) -> None:
            self._drain()
            progress(share)

        try:
            self.session.run(keep)
        finally:
            self._drain()
            self._log.close()

    def _drain(self) -> None:
        for sampled in self.session.drain():
            self._log.write(sampled)
        self._log.look()
