"""The log of a flight, as read from its file."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_text import plain_name
from workbench.common.yaml_files import MAX_YAML_BYTES
from workbench.logs.array_files import ArrayReader, ArrayWriter
from workbench.logs.contents import (
    ACTIONS_CHANNEL,
    SCENARIO_ATTACHMENT,
    STATE_CHANNEL,
    read_action,
)
from workbench.logs.log_process import read_in_process
from workbench.logs.logged_topic import LoggedTopic, short_topic_name
from workbench.logs.readers.log_reader import LogFile
from workbench.logs.readers.packed import log_stem
from workbench.scenario.scenario_file import parse_scenario

WORKBENCH_LOG_FORMAT = "workbench log"

if TYPE_CHECKING:
    from workbench.scenario.scenario import Action, Scenario


@dataclass(frozen=True, eq=False)
class LoggedAction:
    """An action in flight, with its time [s] and who did it."""

    by: str
    action: "Action"


@dataclass(frozen=True, eq=False)
class LogRecord:
    """A flight from its log.

    Attributes:
        path: of the log.
        vehicle: its name.
        physics_step: [s].
        versions: of the software that computed it, by name; see `versions`.
        scenario_text: the scenario flown, as YAML.
        settings: parameter values that replaced those of the scenario.
        values: all parameter values at the start.
        topics: those with messages, by their short names, without the prefix /dh_drone/.
        remark: a sentence on what is missing, "" if nothing is.
        controller: name, file and sha256 of the control law; empty in logs of earlier versions.
        law: text of its file, "" in logs of earlier versions.
        estimator: name, file and sha256 of the user's own estimator; empty without one.
        laws: texts of laws that took over in flight, by the name in their action.
        imported: data of an imported log that are not in its messages, as JSON; "" for our own
            flights.
    """

    path: Path
    vehicle: str
    physics_step: float
    versions: Mapping[str, str]
    scenario_text: str
    settings: Mapping[str, float]
    values: Mapping[str, float]
    topics: Mapping[str, LoggedTopic]
    remark: str
    controller: Mapping[str, str] = field(default_factory=dict)
    law: str = ""
    estimator: Mapping[str, str] = field(default_factory=dict)
    laws: Mapping[str, str] = field(default_factory=dict)
    imported: str = ""

    @property
    def duration(self) -> float:
        """Time of the last state [s], or of the last message in an imported log."""
        if self.imported:
            return max((int(topic.t_ns[-1]) for topic in self.topics.values()), default=0) * 1e-9
        t_ns = self.state_ns
        return t_ns[-1] * 1e-9 if len(t_ns) else 0.0

    @cached_property
    def flight(self) -> Flight:
        """The flight: all fields of its messages, as logged, but for those of damaged topics."""
        damaged = [each for each in self.topics.values() if each.damage]
        said = [f"{each.name}: cannot be decoded: {each.damage}" for each in damaged]
        whole = [each for each in self.topics.values() if not each.damage]
        return Flight(
            name=log_stem(self.path),
            source=self.path,
            format=WORKBENCH_LOG_FORMAT,
            signals={each.name: each for topic in whole for each in topic.columns.values()},
            firmware=f"workbench {self.versions.get('workbench', '')}".strip(),
            parameters={
                "vehicle": self.vehicle,
                **({"controller": self.controller["name"]} if "name" in self.controller else {}),
                **self.values,
            },
            remarks=tuple(filter(None, (self.remark, *said))),
            end=self.duration,
        )

    @property
    def state_ns(self) -> tuple[int, ...]:
        """Times of the exact states [ns]."""
        found = self.topics.get(short_topic_name(STATE_CHANNEL.topic))
        return tuple(found.t_ns.tolist()) if found else ()

    @cached_property
    def states(self) -> np.ndarray:
        """Exact states of the plant: q_WB, p_WB, w_WB, v_WB; (n, 13).

        Raises:
            WorkbenchError: if they have other fields in the log.
        """
        found = self.topics.get(short_topic_name(STATE_CHANNEL.topic))
        if found is None:
            return np.zeros((0, 13))
        sizes = {"q_wb": 4, "p_wb": 3, "w_wb": 3, "v_wb": 3}
        names = [f"{name}.{index}" for name, size in sizes.items() for index in range(size)]
        missing = [name for name in names if name not in found.columns]
        if missing:
            raise WorkbenchError(
                f"{self.path}: its exact states have no {missing[0]}: it is damaged"
            )
        return np.column_stack([found.columns[name].values for name in names])

    @cached_property
    def done(self) -> "tuple[LoggedAction, ...]":
        """All actions, in order.

        Raises:
            WorkbenchError: if this version of the workbench does not know an action.
        """
        found = self.topics.get(short_topic_name(ACTIONS_CHANNEL.topic))
        if found is None:
            return ()
        try:
            columns = (found.columns[name].values for name in ("step", "by", "action"))
            return tuple(
                LoggedAction(str(by), read_action(int(step) * self.physics_step, str(text)))
                for step, by, text in zip(*columns, strict=True)
            )
        except (KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
            raise WorkbenchError(
                f"{self.path}: its record of commands cannot be read: {error}"
            ) from error

    def scenario(self) -> "Scenario":
        """Return the scenario.

        Raises:
            WorkbenchError: if it is invalid for this version of the workbench.
        """
        if self.imported:
            raise WorkbenchError(
                f"{self.path}: comes from another program: it has no scenario to fly again"
            )
        try:
            if len(self.scenario_text) > MAX_YAML_BYTES:
                raise WorkbenchError(f"it has more than {MAX_YAML_BYTES // 1_000_000} MB")
            return parse_scenario(self.path / SCENARIO_ATTACHMENT, self.scenario_text)
        except WorkbenchError as error:
            raise WorkbenchError(f"{self.path}: its scenario cannot be read: {error}") from error

    def described(self, arrays: ArrayWriter) -> dict[str, Any]:
        """Return the log in JSON types, for `from_description`, and write its arrays."""
        return {
            "vehicle": self.vehicle,
            "physics_step": self.physics_step,
            "versions": self.versions,
            "scenario_text": self.scenario_text,
            "settings": self.settings,
            "values": self.values,
            "topics": [each.described(arrays) for each in self.topics.values()],
            "remark": self.remark,
            "controller": self.controller,
            "law": self.law,
            "estimator": self.estimator,
            "laws": self.laws,
            "imported": self.imported,
        }

    @classmethod
    def from_description(
        cls, said: Mapping[str, Any], path: Path, arrays: ArrayReader
    ) -> "LogRecord":
        """Return the log from its description.

        Raises:
            KeyError, TypeError, ValueError, AttributeError, OSError: if it is invalid.
        """
        topics = (LoggedTopic.from_description(each, arrays) for each in said["topics"])
        return cls(
            path=path,
            vehicle=plain_name(str(said["vehicle"])),
            physics_step=float(said["physics_step"]),
            versions=_texts_of(said["versions"]),
            scenario_text=str(said["scenario_text"]),
            settings=_numbers_of(said["settings"]),
            values=_numbers_of(said["values"]),
            topics={each.short: each for each in topics},
            remark=str(said["remark"]),
            controller=_texts_of(said["controller"]),
            law=str(said["law"]),
            estimator=_texts_of(said["estimator"]),
            laws=_texts_of(said["laws"]),
            imported=str(said["imported"]),
        )


def _texts_of(said: Mapping[str, Any]) -> dict[str, str]:
    return {str(name): str(value) for name, value in said.items()}


def _numbers_of(said: Mapping[str, Any]) -> dict[str, float]:
    return {str(name): float(value) for name, value in said.items()}


def read_log(path: Path | str, progress: Callable[[float], None] | None = None) -> LogRecord:
    """Read a log as far as it is readable, in a process with limits of time and memory.

    Args:
        path: the file.
        progress: called with the share done, 0 .. 1, from another thread.

    Raises:
        WorkbenchError: if it cannot be read, or is not a log of the workbench.
    """
    file = Path(path)

    def made(said: Any, arrays: ArrayReader) -> LogRecord:
        return LogRecord.from_description(said["log"], file, arrays)

    return read_in_process(LogFile(file), made, progress, own=True)
