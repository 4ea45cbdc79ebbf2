"""The log of a flight, as read from its file."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_text import plain_name
from workbench.common.yaml_files import MOST_BYTES, refuse_bombs
from workbench.logs.array_files import ArrayReader, ArrayWriter
from workbench.logs.contents import ACTIONS, SCENARIO, STATE, read_action, read_scenario
from workbench.logs.flight_record import Signal
from workbench.logs.log_process import read_held
from workbench.logs.series import LoggedTopic

if TYPE_CHECKING:
    from workbench.scenario.scenario import Action, Scenario


@dataclass(frozen=True, eq=False)
class Done:
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

    @property
    def state_ns(self) -> tuple[int, ...]:
        """Times of the exact states [ns]."""
        found = self.topics.get(short_name(STATE.topic))
        return tuple(found.t_ns.tolist()) if found else ()

    @cached_property
    def states(self) -> np.ndarray:
        """Exact states of the plant: q_WB, p_WB, w_WB, v_WB; (n, 13).

        Raises:
            WorkbenchError: if they have other fields in the log.
        """
        found = self.topics.get(short_name(STATE.topic))
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
    def done(self) -> "tuple[Done, ...]":
        """All actions, in order.

        Raises:
            WorkbenchError: if this version of the workbench does not know an action.
        """
        found = self.topics.get(short_name(ACTIONS.topic))
        if found is None:
            return ()
        try:
            columns = (found.columns[name].values for name in ("step", "by", "action"))
            return tuple(
                Done(str(by), read_action(int(step) * self.physics_step, str(text)))
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
            if len(self.scenario_text) > MOST_BYTES:
                raise ValueError(f"it has more than {MOST_BYTES // 1_000_000} MB")
            refuse_bombs(self.path / SCENARIO, self.scenario_text)
            return read_scenario(self.scenario_text)
        except (RuntimeError, TypeError, ValueError, yaml.YAMLError) as error:
            reason = " ".join(str(error).split())
            raise WorkbenchError(f"{self.path}: its scenario cannot be read: {reason}") from error

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
            versions=_texts(said["versions"]),
            scenario_text=str(said["scenario_text"]),
            settings=_numbers(said["settings"]),
            values=_numbers(said["values"]),
            topics={each.short: each for each in topics},
            remark=str(said["remark"]),
            controller=_texts(said["controller"]),
            law=str(said["law"]),
            estimator=_texts(said["estimator"]),
            laws=_texts(said["laws"]),
            imported=str(said["imported"]),
        )

    def between(self, begin: float, end: float) -> "LogRecord":
        """Return the log with only the messages of a time span [s].

        Raises:
            WorkbenchError: if there are none.
        """
        topics = {name: topic.between(begin, end) for name, topic in self.topics.items()}
        kept = {name: topic for name, topic in topics.items() if len(topic.t_ns)}
        if not kept:
            raise WorkbenchError(f"{self.path}: has nothing between {begin:g} and {end:g} s")
        return replace(self, topics=kept)

    def names(self) -> list[str]:
        """Return TOPIC.FIELD of every series."""
        return [series.name for topic in self.topics.values() for series in topic.columns.values()]

    def series(self, name: str) -> Signal:
        """Return a series by TOPIC.FIELD, such as velocity_data.v_x.

        Raises:
            WorkbenchError: if there is none; it suggests similar ones.
        """
        found = self.several(name)
        if len(found) > 1 or short_name(name) != found[0].name:
            raise WorkbenchError(f"{name} has {len(found)} fields: name one, as {found[0].name}")
        return found[0]

    def several(self, name: str) -> list[Signal]:
        """Return the series of a TOPIC, of a TOPIC.FIELD, or of all components of a field.

        Raises:
            WorkbenchError: if there is none; it suggests similar ones.
        """
        topic, _, path = short_name(name).partition(".")
        if topic not in self.topics:
            raise unknown_name("topic", topic, self.topics)
        columns = self.topics[topic].columns
        found = [
            series
            for each, series in columns.items()
            if not path or each == path or each.startswith(f"{path}.")
        ]
        if not found:
            raise unknown_name(f"field of {topic},", path, columns)
        return found


def _texts(said: Mapping[str, Any]) -> dict[str, str]:
    return {str(name): str(value) for name, value in said.items()}


def _numbers(said: Mapping[str, Any]) -> dict[str, float]:
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

    return read_held(file, made, progress, own=True)


def short_name(topic: str) -> str:
    """Return the name of a topic as used on the command line."""
    return re.sub(r"^/(dh_drone/)?", "", topic)
