"""State of a sensor, in words; no Qt."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

from workbench.gui.instruments.instrument import Sign
from workbench.gui.units import age_text
from workbench.live.view import LiveView
from workbench.plant.faults import Fault
from workbench.session.snapshot import SensorStatus, Snapshot

MAX_AGE_PERIODS = 3.0
"""A reading is old if its age exceeds this number of periods plus its latency..."""
READING_AGE_MARGIN_S = 0.02
"""...plus this [s]: the display lags a little."""
ROUND_AGES_S = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
"""Age limits that the text for a good reading uses [s]."""


class SensorHealth(Enum):
    """Health of a sensor: a word, and its sign."""

    ABSENT = "none", Sign.OFF
    """The drone has no such sensor."""
    OFF = "off", Sign.OFF
    IN_USE = "in use", Sign.OFF
    """The estimator reads it, and nothing else does."""
    WAITING = "waiting", Sign.OFF
    """It has delivered nothing yet."""
    GOOD = "good", Sign.GOOD
    OLD = "old", Sign.WARNING
    FAULTY = "faulty", Sign.BAD
    """A fault was commanded."""

    @property
    def word(self) -> str:
        """Its word."""
        return self.value[0]

    @property
    def sign(self) -> Sign:
        """Its sign."""
        return self.value[1]


@dataclass(frozen=True)
class SensorState:
    """State of a sensor.

    Attributes:
        health: its health.
        note: text beside its name, with the age of its reading.
        advice: what to do if it does not measure, as a sentence; else "".
    """

    health: SensorHealth
    note: str
    advice: str = ""

    @property
    def measures(self) -> bool:
        """Whether there is a reading of any age."""
        return self.health in (SensorHealth.GOOD, SensorHealth.OLD, SensorHealth.FAULTY)


def sensor_state(view: LiveView, snapshot: Snapshot, kind: str) -> SensorState:
    """Return the state of the first sensor of a kind."""
    found = next((each for each in snapshot.sensors if each.kind == kind), None)
    if found is None:
        return silent_state(view, kind)
    if found.fault is not Fault.NONE:
        word = found.fault.name.lower()
        age = f", {age_text(found.age)} old" if math.isfinite(found.age) else ""
        health = SensorHealth.FAULTY if math.isfinite(found.age) else SensorHealth.WAITING
        return SensorState(
            health, f"{word}{age}", f"It is {word}: a fault is set; set {kind}_fault to 0."
        )
    if not math.isfinite(found.age):
        return SensorState(
            SensorHealth.WAITING, "no reading yet", f"{_kind_name(kind)} has just started."
        )
    if found.age > _usual_age(view, found):
        return SensorState(SensorHealth.OLD, f"old: {age_text(found.age)}")
    return SensorState(SensorHealth.GOOD, f"under {age_text(_round_age(found.age))} old")


def worst_state(view: LiveView, snapshot: Snapshot, kinds: Iterable[str]) -> SensorState:
    """Return the worst state among sensors; that of an old or failed one has its kind's name."""
    states = {kind: sensor_state(view, snapshot, kind) for kind in kinds}
    order = list(SensorHealth)
    kind, worst = max(
        states.items(), key=lambda each: order.index(each[1].health) if each[1].measures else 0
    )
    if worst.health not in (SensorHealth.OLD, SensorHealth.FAULTY):
        return worst
    return replace(worst, note=f"{kind_word(kind)} {worst.note}")


def _round_age(age: float) -> float:
    """Return the next round age [s]: one that changes all the time is illegible."""
    return next((each for each in ROUND_AGES_S if age < each), math.ceil(age))


def _usual_age(view: LiveView, status: SensorStatus) -> float:
    """Return the largest normal age of a reading [s]."""
    rate = status.rate or status.asked_rate
    latency = 0.0
    if view.scenario is not None:
        named = view.scenario.sensors.latency
        latency = named.get(status.name, named.get(status.kind, 0.0))
    return latency + MAX_AGE_PERIODS / max(rate, 1e-3) + READING_AGE_MARGIN_S


def silent_state(view: LiveView, kind: str) -> SensorState:
    """Return the state of a kind that does not measure, with how to enable it."""
    name = _kind_name(kind)
    if view.vehicle is not None and all(each.kind != kind for each in view.vehicle.sensors):
        return SensorState(
            SensorHealth.ABSENT,
            "none",
            f"{view.vehicle.name} has no {kind_word(kind)} in its description.",
        )
    if kind == "imu" and view.scenario is not None and view.scenario.is_estimated:
        return SensorState(
            SensorHealth.IN_USE,
            "read by the estimator",
            "The estimator reads the IMU. Fly with it here or from Settings to see its readings.",
        )
    return SensorState(
        SensorHealth.OFF,
        "off",
        f"{name} is off in this flight. Fly with it here or from Settings.",
    )


def _kind_name(kind: str) -> str:
    """Return what a kind is called at the beginning of a sentence."""
    return "GPS" if kind == "gps" else f"The {kind_word(kind)}"


def kind_word(kind: str) -> str:
    """Return a kind in words."""
    return {"imu": "IMU", "gps": "GPS"}.get(kind, kind.replace("_", " "))
