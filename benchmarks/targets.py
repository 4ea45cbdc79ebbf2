"""The requirements of the benchmarks, looked up in the figures of a run."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

Figures = dict[str, Any]
"""Rows by benchmark, as in docs/performance.json."""


@dataclass(frozen=True)
class Target:
    """A requirement, and where its figure is.

    Attributes:
        what: the quantity, in words.
        limit: limit of the median.
        at_least: whether more is better; else it is the most that may be.
        find: the figure: a spread, or a number.
    """

    what: str
    limit: float
    at_least: bool
    find: Callable[[Figures], Any]

    def holds(self, figures: Figures) -> bool:
        """Return whether it does.

        Raises:
            LookupError: if it was not measured.
        """
        measured = self.measured(figures)
        value = measured["median"] if isinstance(measured, dict) else measured
        return bool(value >= self.limit if self.at_least else value <= self.limit)

    def measured(self, figures: Figures) -> Any:
        """Return the figure: a spread, or a number.

        Raises:
            LookupError: if it was not measured.
        """
        return self.find(figures)


def row(figures: Figures, benchmark: str, **wanted: Any) -> dict[str, Any]:
    """Return the row of a benchmark whose fields are as wanted; words may be beginnings.

    Raises:
        LookupError: if there is none.
    """
    rows = figures[benchmark]
    for each in rows if isinstance(rows, list) else [rows]:
        if all(_fits(each.get(name), value) for name, value in wanted.items()):
            found: dict[str, Any] = each
            return found
    raise LookupError(f"{benchmark} has no row {wanted}")


def _fits(found: Any, wanted: Any) -> bool:
    if isinstance(wanted, str):
        return isinstance(found, str) and found.startswith(wanted)
    return bool(found == wanted)


def _live(name: str, figures: Figures) -> Any:
    return row(figures, "live_diagram", name=name)["to_least"]


def _sweep(simulator: str) -> Callable[[Figures], Any]:
    return lambda figures: row(figures, "sweep", simulator=simulator, candidates=1024)[
        "ours_as_often"
    ]


def _fast(figures: Figures, table: str, **wanted: Any) -> dict[str, Any]:
    return row(figures["fast_flights"], table, **wanted)


def _batch(how: str, column: str, figures: Figures) -> Any:
    return _fast(figures, "batches", flown_by=f"crazyflow {how}", periods=10)[column]


def _largest(column: str) -> Callable[[Figures], Any]:
    return lambda figures: max(each[column] for each in figures["agreement"])


def _watchers(figures: Figures, beside: str) -> Any:
    ages = figures["link_age"]["ages"]
    return next(each for each in ages if (each["clients"], each["beside"]) == ("eight", beside))


def _command(name: str) -> Callable[[Figures], Any]:
    return lambda figures: next(
        each["to_plant"]
        for each in figures["commands"]["commands"]
        if each["name"].startswith(f"workbench {name}")
    )


def _screen(name: str, column: str) -> Callable[[Figures], Any]:
    return lambda figures: next(
        each[column] for each in figures["app"]["screens"] if each["screen"] == name
    )


def _shown(figures: Figures) -> list[dict[str, Any]]:
    """Return the rows of all screens, and of all pages of the Tuning screen."""
    return [*figures["app"]["screens"], *figures["app"]["pages"]]


def _slowest(column: str) -> Callable[[Figures], Any]:
    return lambda figures: min(
        each[column] for each in figures["app"]["pages"] if not math.isnan(each[column])
    )


TARGETS = (
    *(
        Target(
            f"speed of a live flight ({name}), relative to the least diagram that flies",
            limit,
            True,
            partial(_live, name),
        )
        for name, limit in (
            ("truth, wind and battery", 0.4),
            ("EKF, filters, all sensors but the camera", 0.12),
            ("law at 1 kHz", 0.05),
            ("landed and idle", 0.1),
        )
    ),
    Target(
        "1,024 compiled flights a second, relative to crazyflow as it comes",
        8,
        True,
        _sweep("crazyflow as it comes"),
    ),
    Target(
        "1,024 compiled flights a second, relative to crazyflow on two devices",
        4,
        True,
        _sweep("crazyflow on two devices"),
    ),
    *(
        Target(
            f"{what} of a batch of 1,024 in equal processor time, relative to crazyflow {how}",
            least,
            True,
            partial(_batch, how, column),
        )
        for how, least in (("as it comes", 15), ("on two devices", 12))
        for what, column in (
            ("physics steps", "steps_as_fast_by_processor"),
            ("seconds flown", "ours_as_fast_by_processor"),
        )
    ),
    *(
        Target(
            f"physics steps a second of a batch of 1,024, relative to crazyflow {how}",
            least,
            True,
            partial(_batch, how, "steps_as_fast"),
        )
        for how, least in (("as it comes", 15), ("on two devices", 12))
    ),
    Target("1,024 compiled flights a second, relative to RotorPy", 50, True, _sweep("RotorPy")),
    Target(
        "1,024 compiled flights a second, relative to Drake diagrams", 300, True, _sweep("Drake")
    ),
    Target(
        "difference of compiled flights from the diagram, m/s", 1e-3, False, _largest("velocity")
    ),
    Target(
        "difference of compiled flights from the diagram, rad/s",
        5e-3,
        False,
        _largest("angular_velocity"),
    ),
    Target(
        "growth of the cost with candidates, exponent",
        1.0,
        False,
        lambda figures: row(figures, "growth", name="candidates")["exponent"],
    ),
    Target(
        "peak memory of 16,384 candidates, MB",
        500,
        False,
        lambda figures: row(figures, "memory", name="sweep", amount=16384)["megabytes"],
    ),
    Target(
        "the tuning screen's map, s",
        0.2,
        False,
        lambda figures: row(figures, "gain_map")["seconds"],
    ),
    Target(
        "`workbench --help`, s",
        0.2,
        False,
        lambda figures: row(figures, "start_up", name="workbench --help")["wall"],
    ),
    Target(
        "time of `step` with its picture, relative to loading Drake's plant",
        5,
        False,
        _command("step"),
    ),
    Target(
        "time of `workbench margins` (formerly `judge`), relative to loading Drake's plant",
        7,
        False,
        _command("judge"),
    ),
    Target(
        "time of `linearize`, relative to loading Drake's plant", 3, False, _command("linearize")
    ),
    Target(
        "time of `sweep` of 1,024, relative to loading Drake's plant", 6, False, _command("sweep")
    ),
    Target("time of `inspect`, relative to loading Drake's plant", 1.5, False, _command("inspect")),
    Target(
        "time of `regress steps`, relative to loading Drake's plant", 10, False, _command("regress")
    ),
    Target(
        "the longest silence of a first use, s",
        5,
        False,
        lambda figures: max(each["silence"] for each in figures["commands"]["first_uses"]),
    ),
    Target(
        "`workbench step` with its plots, s",
        2.0,
        False,
        lambda figures: row(figures, "start_up", name="workbench step --axis x --amplitude 1")[
            "wall"
        ],
    ),
    Target(
        "model and margins of all loops, relative to a frame of 20 ms",
        1.0,
        False,
        lambda figures: row(figures, "design", name="model and margins")["ratio"],
    ),
    Target(
        "age of what eight watchers of eight topics read, median, ms",
        1.0,
        False,
        lambda figures: _watchers(figures, "nobody")["age_50"],
    ),
    Target(
        "the same, 99th percentile, ms",
        5.0,
        False,
        lambda figures: _watchers(figures, "nobody")["age_99"],
    ),
    Target(
        "samples that a watcher missed, although it acknowledges",
        0,
        False,
        lambda figures: _watchers(figures, "nobody")["gaps"],
    ),
    Target(
        "real-time factor of a flight beside eight watchers",
        0.99,
        True,
        lambda figures: figures["link_age"]["loads"][0]["real_time_factor"],
    ),
    Target(
        "age of what a watcher of 20 frames a second reads, worst, ms",
        1000.0,
        False,
        lambda figures: figures["link_age"]["ages"][2]["age_worst"],
    ),
    Target(
        "others' 99th percentile beside two slow watchers, relative to that without",
        2.0,
        False,
        lambda figures: figures["link_age"]["others_99"],
    ),
    Target(
        "median age of what eight watchers read, relative to a server that only copies the bytes",
        3.0,
        False,
        lambda figures: figures["link_age"]["over_bare_50"],
    ),
    Target(
        "99th percentile of the age of what eight watchers read, relative to a server that only "
        "copies the bytes",
        1.5,
        False,
        lambda figures: figures["link_age"]["over_bare_99"],
    ),
    Target(
        "samples that 64 watchers of one topic missed",
        0,
        False,
        lambda figures: figures["link_age"]["ages"][-1]["gaps"],
    ),
    Target(
        "flights in which the hold came too late, of all faults",
        0,
        False,
        lambda figures: sum(each["late"] for each in figures["link_hold"]["rows"]),
    ),
    Target(
        "frames a second of the app with twelve curves",
        50,
        True,
        _screen("visualization", "frames"),
    ),
    Target(
        "the same with 48 curves",
        25,
        True,
        _screen("visualization, 48 curves", "frames"),
    ),
    Target(
        "smallest real-time factor of the flight beside any screen or page of the app",
        0.99,
        True,
        lambda figures: min(each["real_time_factor"] for each in _shown(figures)),
    ),
    Target(
        "the app's slots on the slowest of its screens and pages, 99th percentile, ms",
        16,
        False,
        lambda figures: max(each["slot_99"] for each in _shown(figures)),
    ),
    Target(
        "time until the flight has a moved gain, 99th percentile, ms",
        20,
        False,
        lambda figures: figures["app"]["gains"][0]["effect_99"],
    ),
    Target(
        "margins of all loops while a gain moves, a second, on the slowest page",
        15,
        True,
        _slowest("judged"),
    ),
    Target(
        "predicted steps in the same time, a second",
        20,
        True,
        _slowest("predicted"),
    ),
    Target(
        "frequency curves in the same time, a second",
        20,
        True,
        _slowest("drawn"),
    ),
    Target(
        "time from the command to the app's window, s",
        3,
        False,
        lambda figures: figures["app"]["starts"][0]["window"],
    ),
    Target(
        "time to its first flight, s",
        2.5,
        False,
        lambda figures: figures["app"]["starts"][0]["flight"],
    ),
)
