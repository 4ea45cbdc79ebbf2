"""Compare controllers and gains: the same flights, vehicles and margins, one column for each."""

import copy
import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.resources import find_file
from workbench.control.controller import (
    Controller,
    is_shipped,
    load_controller,
    not_repeatable,
)
from workbench.control.schedule import split_label
from workbench.design.flier import Flier
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.judge.step_pair import STEPS
from workbench.design.linear.operating_point import HOLDING, HOVER
from workbench.design.linear.study import LinearStudy
from workbench.design.linear_step import DecayTimes
from workbench.design.lost import find_loss
from workbench.design.response_metrics import response_metrics, step_duration
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import START_HEIGHT, fly_step
from workbench.design.tune.measure import noise_amplification
from workbench.design.tune.tuner import Tuner
from workbench.design.tune.tuning import Tuning
from workbench.design.tune.wish import Wishes, load_wishes, merged, parse_wish
from workbench.gains.gains import flown_by, load_gains, owner_of, save_gains
from workbench.plant.gravity import GRAVITY
from workbench.plant.variation import Variation
from workbench.scenario.axes import find_axis
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Action, FigureEight, Push, Scenario, Start, at_own_period
from workbench.session.recording import Recording

EIGHT = FigureEight([0.0, 0.0, START_HEIGHT], 8.0, 4.0, 8.885, 2)
"""A figure of eight with a largest speed of 4 m/s."""
PUSH_AT, PUSH_TIME, PUSH_SHARE = 1.0, 0.2, 0.5
"""A push to the north: its begin and duration [s], and its force as a share of the weight."""
BACK = 0.05
"""A pushed drone counts as back within this distance [m]."""
OVER = math.radians(179.0)
"""Roll of a start upside down: at 180 deg both ways are equally long and rounding would choose."""
OVER_HEIGHT = 50.0
"""Height of the start upside down [m]."""
UPRIGHT, AT_REST = math.radians(10.0), 1.0
"""The drone has recovered once tilt [rad] and climb rate [m/s] stay below these."""
WIND_AT, WIND, WIND_TIME = 1.0, 8.0, 30.0
"""A steady wind to the east: its begin [s], speed [m/s] and duration [s]."""
AFTER = 10.0
"""Time flown after a push, and from upside down [s]."""
VEHICLES = tuple(
    Variation(mass=mass, inertia=inertia, rotor_lag=lag)
    for mass, inertia, lag in itertools.product((0.8, 1.2), (0.7, 1.3), (1.0, 1.5))
)
"""Vehicles that differ from the one the law knows."""


@dataclass(frozen=True)
class Row:
    """A number used to compare controllers.

    Attributes:
        name: of it.
        unit: SI, or %.
        part: of the comparison that measures it, one of `PARTS`.
        help: what it is.
    """

    name: str
    unit: str
    part: str
    help: str


ROWS = (
    *(
        Row(
            f"{name}_{axis}",
            unit,
            "steps",
            f"step of {size:g} {find_axis(axis).unit} along {axis}: {what}",
        )
        for axis, size in STEPS
        for name, unit, what in (
            ("rise_time", "s", "10 % to 90 %"),
            ("settling_time", "s", "until it stays within 2 %"),
            ("overshoot", "%", "above the steady state"),
            ("steady_state_error", "%", "of the command"),
        )
    ),
    Row("peak_rotor_use", "1", "steps", "largest share of a rotor's speed limit in these steps"),
    Row(
        "path",
        "m",
        "path",
        "largest distance from the commanded position along the figure of eight",
    ),
    Row("path_without", "m", "path", "the same without the path's acceleration fed forward"),
    Row("push_distance", "m", "push", "largest distance after a push of half the weight for 0.2 s"),
    Row("push_recovery", "s", "push", "from its start until it stays within 5 cm"),
    Row("over_recovery", "s", "upside_down", "from upside down until it stays upright"),
    Row("over_height", "m", "upside_down", "height lost by then"),
    Row("wind_error", "m", "wind", "distance from the held position after 30 s of wind of 8 m/s"),
    Row("worst_overshoot", "%", "vehicles", "mass ± 20 %, inertia ± 30 %, rotors 1.5 as slow"),
    Row("lost", "1", "vehicles", "of 8 such vehicles, those that a step loses"),
    Row("own_disk_margin", "1", "margins", "least of its own loops, one at a time"),
    Row("input_disk_margin", "1", "margins", "at the plant's input, all at once"),
    Row("noise_amplification", "N·s/rad", "margins", "rms of thrust over noise of body rates"),
)
PARTS = tuple(dict.fromkeys(row.part for row in ROWS))
UNMET = Row("unmet_wishes", "1", "tune", "wishes that the gains found for them do not meet")
PANELS = ("x", "y", "z", "yaw", "path", "push", "upside_down", "wind")
"""Panels of the picture, each with one curve per controller."""
Curve = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Candidate:
    """A controller with its gains.

    Attributes:
        name: of its column: that of the controller, or of its gain file.
        reference: of the controller, see `load_controller`.
        law: the controller.
        gains: path of its gain file; "" for those of the vehicle.
    """

    name: str
    reference: str
    law: Controller
    gains: str = ""


@dataclass
class Compared:
    """The results of one controller.

    Attributes:
        name: of its column, see `Candidate`.
        numbers: by the name of their row; NaN where there is none.
        remarks: by the name of a row: why it has no number, or a comment on the number.
        curves: by panel, see `PANELS`.
        gains: tuned for the wishes, by name; empty without wishes.
    """

    name: str
    numbers: dict[str, float] = field(default_factory=dict)
    remarks: dict[str, str] = field(default_factory=dict)
    curves: dict[str, Curve] = field(default_factory=dict)
    gains: dict[str, float] = field(default_factory=dict)

    def note(self, name: str, value: float, remark: str = "") -> None:
        """Note a number, and a remark where there is one."""
        self.numbers[name] = value
        if remark:
            self.remarks[name] = remark

    def none(self, names: Sequence[str], why: str) -> None:
        """Note why there are no numbers."""
        for name in names:
            self.note(name, math.nan, why)


@dataclass(frozen=True)
class Comparison:
    """Controllers beside each other.

    Attributes:
        vehicle: its name.
        rows: that were measured.
        controllers: a column each.
    """

    vehicle: str
    rows: tuple[Row, ...]
    controllers: tuple[Compared, ...]


def find_candidates(texts: Sequence[str]) -> tuple[Candidate, ...]:
    """Return what to compare.

    Args:
        texts: each a shipped controller or a .py file, a gain file (.yaml) of a shipped one, or
            both as CONTROLLER=GAINS.yaml.

    Raises:
        WorkbenchError: for one that does not load, or if two have the same name.
    """
    found: list[Candidate] = []
    for text in texts:
        reference, sign, gains = text.rpartition("=") if _is_gains(text) else (text, "", "")
        if gains:
            path = find_file(gains)
            reference = reference if sign else flown_by(_shipped_owner(path), gains)
            law = load_controller(reference)
            load_gains(path, law)
            candidate = Candidate(path.stem, reference, law, str(path))
        else:
            law = load_controller(reference)
            candidate = Candidate(law.name, reference, law)
        if law.program:
            raise not_repeatable(law.name)
        if candidate.name in [other.name for other in found]:
            raise WorkbenchError(
                f"two controllers are called {candidate.name}: name each controller and gain "
                "file once, and call files otherwise"
            )
        found.append(candidate)
    return tuple(found)


def _is_gains(text: str) -> bool:
    return text.endswith((".yaml", ".yml"))


def _shipped_owner(path: Path) -> str:
    """Return the shipped controller that a gain file names."""
    owner, _ = split_label(owner_of(path))
    if not is_shipped(owner):
        raise WorkbenchError(
            f"{path}: its gains are of the controller {owner}: name its file, too, as "
            f"{owner}.py={path.name}"
        )
    return owner


def chosen_parts(names: Sequence[str]) -> tuple[str, ...]:
    """Return the named parts of a comparison, or all if none is named.

    Raises:
        WorkbenchError: for an unknown one.
    """
    for name in names:
        if name not in PARTS:
            raise unknown_name("part of a comparison", name, PARTS)
    return tuple(part for part in PARTS if part in names or not names)


def compare(
    controllers: Sequence[str],
    scenario: Scenario | None = None,
    *,
    parts: Sequence[str] = (),
    wishes: Sequence[str] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Comparison:
    """Fly and judge controllers on one vehicle, each with its gains for that vehicle.

    With wishes, each controller is first tuned for them. The comparison is then of structures, not
    of how well their gains were set.

    Args:
        controllers: see `find_candidates`.
        scenario: its vehicle, world and rates are used, and its figure of eight if it has one. Its
            gain file is used for the controller that it belongs to, unless that has its own.
        parts: names from `PARTS`; all if empty.
        wishes: texts, or paths of wish files, see docs/tuning.md; an empty sequence uses the wishes
            that follow from the vehicle. None does no tuning.
        progress: called with the share done, 0 .. 1.

    Raises:
        WorkbenchError: if a controller, the vehicle or a wish cannot be read.
    """
    candidates, chosen = find_candidates(controllers), chosen_parts(parts)
    scenario = scenario or Scenario()
    asked = [wishes_of(wishes or (), each.law) for each in candidates]
    count, done = len(candidates) * (len(chosen) + (wishes is not None)), 0

    def say(share: float) -> None:
        if progress:
            progress((done + share) / count)

    found, vehicle = [], ""
    rows = [UNMET] * (wishes is not None) + [row for row in ROWS if row.part in chosen]
    with TemporaryDirectory() as folder:
        for candidate, each in zip(candidates, asked, strict=True):
            flown = _flown_by(scenario, candidate)
            tuned = None
            if wishes is not None:
                tuned = Tuner(flown, each).run(lambda progress: say(progress.share))
                flown.vehicle.gains = str(Path(folder) / f"{candidate.name}.yaml")
                save_gains(Path(flown.vehicle.gains), tuned.profile)
                done += 1
            bench = _Bench(flown, candidate, say)
            if tuned:
                _note_tuned(bench.found, tuned)
            vehicle = bench.study.vehicle.name
            for part in chosen:
                names = [row.name for row in ROWS if row.part == part]
                try:
                    _MEASURE[part](bench)
                except WorkbenchError as error:
                    bench.found.none([n for n in names if n not in bench.found.numbers], str(error))
                done += 1
                say(0.0)
            found.append(bench.found)
    return Comparison(vehicle, tuple(rows), tuple(found))


def wishes_of(texts: Sequence[str], law: Controller) -> Wishes:
    """Return wishes about a controller, given as texts or paths of wish files.

    Raises:
        WorkbenchError: if a wish is invalid, or about a loop that the controller does not have.
    """
    files = [text for text in texts if text.endswith((".yaml", ".yml"))]
    if len(files) > 1:
        raise WorkbenchError(f"{len(files)} files of wishes are named: name one")
    from_file = load_wishes(find_file(files[0]), law) if files else Wishes()
    typed = [wish for text in texts if text not in files for wish in parse_wish(text, law=law)]
    return dataclasses.replace(from_file, wishes=tuple(merged([*from_file.wishes, *typed])))


def _note_tuned(found: Compared, tuned: Tuning) -> None:
    """Note the results of the tuning."""
    unmet = [result.required for result in tuned.as_described if not result.met]
    said = "; ".join(map(str, unmet or tuned.conflicts))
    found.note(UNMET.name, float(len(unmet)), said)
    if not (unmet or tuned.met):
        found.remarks[UNMET.name] = said or "met as described, and not by all vehicles near it"
    found.gains.update(tuned.gains)


def _flown_by(scenario: Scenario, candidate: Candidate) -> Scenario:
    """Return a scenario with another controller and its gains, or those that belong to it."""
    flight = copy.deepcopy(scenario)
    flight.controller = candidate.reference
    gains = flight.vehicle.gains
    if candidate.gains:
        flight.vehicle.gains = candidate.gains
    elif gains and owner_of(find_file(gains)) != candidate.law.name:
        flight.vehicle.gains = ""
    return at_own_period(flight)


class _Bench:
    """Flies one candidate and notes its results."""

    def __init__(
        self, scenario: Scenario, candidate: Candidate, say: Callable[[float], None]
    ) -> None:
        self.scenario, self.law, self.say = scenario, candidate.law, say
        self.study = LinearStudy(scenario)
        self.found = Compared(candidate.name)

    def fly(
        self,
        duration: float,
        start: Start | None = None,
        action: Action | None = None,
        eight: FigureEight | None = None,
    ) -> Recording:
        """Return a flight that begins in hover, with one action of the pilot or the air."""
        flight = copy.deepcopy(self.scenario)
        flight.start = start or Start(position=[0.0, 0.0, START_HEIGHT])
        flight.duration, flight.figure_eight = duration, eight
        flight.script = [action] if action else []
        return Flier(flight).fly(self.say, programs=False).recording


def _steps(bench: _Bench) -> None:
    use = 0.0
    for axis, amplitude in STEPS:
        names = [row.name for row in ROWS if row.part == "steps" and row.name.endswith(f"_{axis}")]
        try:
            step = fly_step(
                axis,
                amplitude,
                scenario=bench.scenario,
                progress=bench.say,
            )
        except WorkbenchError as error:
            bench.found.none(names, str(error))
            continue
        use = max(use, step.peak_rotor_use)
        bench.found.curves[axis] = step.time, step.response / amplitude
        if step.loss:
            bench.found.none(names, step.loss.sentence)
            continue
        for name in names:
            value = getattr(step.metrics, name.removesuffix(f"_{axis}"))
            bench.found.note(name, value, step.metrics.withheld if math.isnan(value) else "")
    bench.found.note("peak_rotor_use", use)


def _path(bench: _Bench) -> None:
    eight = bench.scenario.figure_eight or EIGHT
    duration = (eight.laps + 0.5) * eight.period + 1.0
    x, y, z = eight.center
    start = Start(position=[x, y, z])
    flown = []
    for name, feedforward in (("path", True), ("path_without", False)):
        path = dataclasses.replace(eight, feedforward=feedforward)
        flight = bench.fly(duration, start, eight=path)
        flown.append(flight)
        if loss := find_loss(flight):
            bench.found.none([name], loss.sentence)
        else:
            bench.found.note(name, float(_distance(flight, flight.reference[:, 4:7]).max()))
    fed, plain = flown
    if np.array_equal(fed.p_WB, plain.p_WB):
        bench.found.none(["path"], f"{bench.law.name} does not use the path's acceleration")
    bench.found.curves["path"] = fed.p_WB[:, 0], fed.p_WB[:, 1]


def _push(bench: _Bench) -> None:
    vehicle = bench.study.vehicle
    most = parameter_table(bench.law).find("push_y").maximum
    force = min(PUSH_SHARE * vehicle.mass * GRAVITY, most)
    push = Push([0.0, force, 0.0], list(vehicle.p_BoBcm_B), PUSH_TIME)
    flight = bench.fly(PUSH_AT + AFTER, action=Action(at=PUSH_AT, push=push))
    away = _distance(flight, flight.p_WB[0])
    bench.found.curves["push"] = flight.time - PUSH_AT, away
    if loss := find_loss(flight):
        bench.found.none(["push_distance", "push_recovery"], loss.sentence)
        return
    bench.found.note("push_distance", float(away.max()))
    back = _for_good(flight.time, away < BACK)
    why = "" if math.isfinite(back) else f"not back within {BACK:g} m after {AFTER:g} s"
    bench.found.note("push_recovery", back - PUSH_AT, why)


def _upside_down(bench: _Bench) -> None:
    start = Start(position=[0.0, 0.0, OVER_HEIGHT], roll_pitch_yaw=[OVER, 0.0, 0.0])
    flight = bench.fly(AFTER, start)
    height = flight.p_WB[:, 2]
    bench.found.curves["upside_down"] = flight.time, height - OVER_HEIGHT
    upright = flight.z_axis_W[:, 2] > math.cos(UPRIGHT)
    upright &= np.abs(flight.v_WB[:, 2]) < AT_REST
    down = height < flight.vehicle.ground_clearance
    recovered = _for_good(flight.time, upright)
    if down.any():
        fallen = f"falls to the ground in {flight.time[down.argmax()]:.2g} s"
        bench.found.none(["over_recovery", "over_height"], fallen)
    elif math.isfinite(recovered):
        bench.found.note("over_recovery", recovered)
        bench.found.note("over_height", OVER_HEIGHT - float(height.min()))
    else:
        bench.found.none(["over_recovery", "over_height"], f"not upright within {AFTER:g} s")


def _wind(bench: _Bench) -> None:
    action = Action(at=WIND_AT, set={"wind_x": WIND})
    flight = bench.fly(WIND_AT + WIND_TIME, action=action)
    away = _distance(flight, flight.p_WB[0])
    bench.found.curves["wind"] = flight.time - WIND_AT, away
    if loss := find_loss(flight):
        bench.found.none(["wind_error"], loss.sentence)
    else:
        bench.found.note("wind_error", float(away[flight.time > flight.time[-1] - 1.0].mean()))


def _vehicles(bench: _Bench) -> None:
    study = bench.study
    engine = RolloutEngine(
        study.vehicle, bench.scenario.rates, own=study.gains, controller=bench.law
    )
    decay = DecayTimes(bench.scenario)
    worst, lost, odd = 0.0, np.zeros(len(VEHICLES), dtype=bool), ""
    for index, (axis, amplitude) in enumerate(STEPS):
        settled = [decay.of(axis, {}, each) for each in VEHICLES]
        flown = engine.fly(
            [{}] * len(VEHICLES),
            axis,
            amplitude,
            duration=max(map(step_duration, settled)),
            variations=VEHICLES,
        )
        gone = np.isfinite(flown.diverged_at)
        # a drone that is heavier than its controller knows sinks before the edge
        response = flown.response - flown.response[:, :1]
        found = response_metrics(flown.time, response, amplitude)
        known = found.withheld(float(flown.time[-1]), amplitude, np.array(settled))
        lost |= gone
        worst = max(worst, float(known.overshoot[~gone].max(initial=0.0)))
        if wrong := int((amplitude * response[~gone, -1] <= 0.0).sum()):
            odd = f"with {wrong} of the 8 vehicles the {axis} step goes the wrong way"
        elif slow := int(np.isnan(known.overshoot[~gone]).sum()):
            odd = f"with {slow} of the 8 vehicles the {axis} step does not settle"
        bench.say((index + 1) / len(STEPS))
    bench.found.note("lost", float(lost.sum()))
    if odd:
        bench.found.none(["worst_overshoot"], odd)
    else:
        bench.found.note(
            "worst_overshoot", worst, "of those that are not lost" if lost.any() else ""
        )


def _margins(bench: _Bench) -> None:
    steering, holding = bench.study.sampled(), bench.study.sampled(HOLDING)
    loops = judge_loops(steering, holding)
    if loops:
        least, name = min(
            (margin.disk_margin, f"{loop.loop}, at its {cut}")
            for loop in loops
            for cut, margin in (("actuator", loop.actuator), ("error", loop.error))
        )
        bench.found.note("own_disk_margin", least, name)
    else:
        bench.found.none(["own_disk_margin"], f"{bench.law.name} states no LOOPS")
    bench.say(0.5)
    both = [multiloop_margin(bench.study.plant_input(point)) for point in (HOVER, HOLDING)]
    least_of_all = min(both, key=lambda each: each.disk_margin)
    alone = min(least_of_all.alone, key=lambda name: least_of_all.alone[name])
    bench.found.note(
        "input_disk_margin",
        least_of_all.disk_margin,
        f"at {least_of_all.frequency:.3g} rad/s; alone, {alone} has the least: "
        f"{least_of_all.alone[alone]:.2f}",
    )
    noise = noise_amplification(steering)
    why = "" if math.isfinite(noise) else "a mode grows"
    bench.found.note("noise_amplification", noise if not why else math.nan, why)


_MEASURE: Mapping[str, Callable[[_Bench], None]] = {
    "steps": _steps,
    "path": _path,
    "push": _push,
    "upside_down": _upside_down,
    "wind": _wind,
    "vehicles": _vehicles,
    "margins": _margins,
}


def _distance(flight: Recording, place: np.ndarray) -> np.ndarray:
    """Return the distance (N) of a flight from a place (3), or from one at every time (N, 3)."""
    return np.asarray(np.linalg.norm(flight.p_WB - place, axis=1))


def _for_good(time: np.ndarray, good: np.ndarray) -> float:
    """Return the time from which all samples are good [s], NaN if the last one is not."""
    bad = np.flatnonzero(~good)
    if not len(bad):
        return float(time[0])
    return float(time[bad[-1] + 1]) if bad[-1] + 1 < len(time) else math.nan
