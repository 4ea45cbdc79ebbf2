"""Fly and measure the parts of a comparison of controllers."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.comparison import COMPARISON_ROWS, ControllerCandidate, ControllerResult
from workbench.design.flier import Flier
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.judge.step_pair import PAPER_STEPS
from workbench.design.linear.operating_point import HOLDING_POINT, HOVER_POINT
from workbench.design.linear.study import LinearStudy
from workbench.design.linear_step import DecayTimes
from workbench.design.lost import find_loss
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.sensor_set import moving_joints
from workbench.design.step_metrics import step_duration, step_metrics
from workbench.design.step_response import STEP_START_HEIGHT_M, fly_step
from workbench.design.tune.noise_amplification import noise_amplification
from workbench.plant.gravity import GRAVITY
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Action, FigureEight, Push, Scenario, ScenarioStart
from workbench.session.recording import Recording
from workbench.setup import make_setup

COMPARED_FIGURE_EIGHT = FigureEight([0.0, 0.0, STEP_START_HEIGHT_M], 8.0, 4.0, 8.885, 2)
"""A figure of eight with a largest speed of 4 m/s."""
PUSH_START_S, PUSH_DURATION_S, PUSH_WEIGHT_SHARE = 1.0, 0.2, 0.5
"""A push to the north: its begin and duration [s], and its force as a share of the weight."""
RETURNED_RADIUS_M = 0.05
"""A pushed drone counts as back within this distance [m]."""
UPSIDE_DOWN_ROLL_RAD = math.radians(179.0)
"""Roll of a start upside down: at 180 deg both ways are equally long and rounding would choose."""
UPSIDE_DOWN_HEIGHT_M = 50.0
"""Height of the start upside down [m]."""
RECOVERED_TILT_RAD, RECOVERED_CLIMB_M_S = math.radians(10.0), 1.0
"""The drone has recovered once tilt [rad] and climb rate [m/s] stay below these."""
WIND_START_S, WIND_SPEED_M_S, WIND_DURATION_S = 1.0, 8.0, 30.0
"""A steady wind to the east: its begin [s], speed [m/s] and duration [s]."""
RECOVERY_TIME_S = 10.0
"""Time flown after a push, and from upside down [s]."""
COMPARED_VEHICLES = tuple(
    Variation(mass=mass, inertia=inertia, rotor_lag=lag)
    for mass, inertia, lag in itertools.product((0.8, 1.2), (0.7, 1.3), (1.0, 1.5))
)
"""Vehicles that differ from the one the law knows."""


class ComparisonBench:
    """Flies one candidate and notes its results."""

    def __init__(
        self, scenario: Scenario, candidate: ControllerCandidate, say: Callable[[float], None]
    ) -> None:
        self.law, self.say, self.setup = candidate.law, say, make_setup(scenario)
        self.study = LinearStudy(self.setup)
        self.found = ControllerResult(candidate.name)

    def fly(
        self,
        duration: float,
        start: ScenarioStart | None = None,
        action: Action | None = None,
        eight: FigureEight | None = None,
    ) -> Recording:
        """Return a flight that begins in hover, with one action of the pilot or the air."""
        flight = dataclasses.replace(
            self.setup.scenario,
            start=start or ScenarioStart(position=[0.0, 0.0, STEP_START_HEIGHT_M]),
            duration=duration,
            figure_eight=eight,
            script=[action] if action else [],
        )
        return Flier(self.setup.with_scenario(flight)).fly(self.say, programs=False).recording


def _measure_steps(bench: ComparisonBench) -> None:
    use = 0.0
    for axis, amplitude in PAPER_STEPS:
        names = [
            row.name
            for row in COMPARISON_ROWS
            if row.part == "steps" and row.name.endswith(f"_{axis}")
        ]
        try:
            step = fly_step(
                axis,
                amplitude,
                scenario=bench.setup,
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


def _measure_path(bench: ComparisonBench) -> None:
    eight = bench.setup.scenario.figure_eight or COMPARED_FIGURE_EIGHT
    duration = (eight.laps + 0.5) * eight.period + 1.0
    x, y, z = eight.center
    start = ScenarioStart(position=[x, y, z])
    flown = []
    for name, feedforward in (("path", True), ("path_without", False)):
        path = dataclasses.replace(eight, feedforward=feedforward)
        flight = bench.fly(duration, start, eight=path)
        flown.append(flight)
        if loss := find_loss(flight):
            bench.found.none([name], loss.sentence)
        else:
            bench.found.note(name, float(_distance_from(flight, flight.reference[:, 4:7]).max()))
    fed, plain = flown
    if np.array_equal(fed.p_WB, plain.p_WB):
        bench.found.none(["path"], f"{bench.law.name} does not use the path's acceleration")
    bench.found.curves["path"] = fed.p_WB[:, 0], fed.p_WB[:, 1]


def _measure_push(bench: ComparisonBench) -> None:
    vehicle = bench.study.vehicle
    most = bench.setup.table.find("push_y").maximum
    force = min(PUSH_WEIGHT_SHARE * vehicle.mass * GRAVITY, most)
    push = Push([0.0, force, 0.0], list(vehicle.p_BoBcm_B), PUSH_DURATION_S)
    flight = bench.fly(PUSH_START_S + RECOVERY_TIME_S, action=Action(at=PUSH_START_S, push=push))
    away = _distance_from(flight, flight.p_WB[0])
    bench.found.curves["push"] = flight.time - PUSH_START_S, away
    if loss := find_loss(flight):
        bench.found.none(["push_distance", "push_recovery"], loss.sentence)
        return
    bench.found.note("push_distance", float(away.max()))
    back = _for_good(flight.time, away < RETURNED_RADIUS_M)
    why = (
        ""
        if math.isfinite(back)
        else f"not back within {RETURNED_RADIUS_M:g} m after {RECOVERY_TIME_S:g} s"
    )
    bench.found.note("push_recovery", back - PUSH_START_S, why)


def _measure_upside_down(bench: ComparisonBench) -> None:
    start = ScenarioStart(
        position=[0.0, 0.0, UPSIDE_DOWN_HEIGHT_M], roll_pitch_yaw=[UPSIDE_DOWN_ROLL_RAD, 0.0, 0.0]
    )
    flight = bench.fly(RECOVERY_TIME_S, start)
    height = flight.p_WB[:, 2]
    bench.found.curves["upside_down"] = flight.time, height - UPSIDE_DOWN_HEIGHT_M
    upright = flight.z_axis_W[:, 2] > math.cos(RECOVERED_TILT_RAD)
    upright &= np.abs(flight.v_WB[:, 2]) < RECOVERED_CLIMB_M_S
    down = height < flight.vehicle.ground_clearance
    recovered = _for_good(flight.time, upright)
    if down.any():
        fallen = f"falls to the ground in {flight.time[down.argmax()]:.2g} s"
        bench.found.none(["over_recovery", "over_height"], fallen)
    elif math.isfinite(recovered):
        bench.found.note("over_recovery", recovered)
        bench.found.note("over_height", UPSIDE_DOWN_HEIGHT_M - float(height.min()))
    else:
        bench.found.none(
            ["over_recovery", "over_height"], f"not upright within {RECOVERY_TIME_S:g} s"
        )


def _measure_wind(bench: ComparisonBench) -> None:
    action = Action(at=WIND_START_S, set={"wind_x": WIND_SPEED_M_S})
    flight = bench.fly(WIND_START_S + WIND_DURATION_S, action=action)
    away = _distance_from(flight, flight.p_WB[0])
    bench.found.curves["wind"] = flight.time - WIND_START_S, away
    if loss := find_loss(flight):
        bench.found.none(["wind_error"], loss.sentence)
    else:
        bench.found.note("wind_error", float(away[flight.time > flight.time[-1] - 1.0].mean()))


def _measure_vehicles(bench: ComparisonBench) -> None:
    setup = bench.setup
    if setup.vehicle.joints:
        why = f"eight vehicles fly compiled, and {moving_joints(setup.vehicle)}"
        bench.found.none(["lost", "worst_overshoot"], why)
        return
    engine = RolloutEngine(
        setup.vehicle, setup.rates, own=setup.values, controller=setup.controller
    )
    decay = DecayTimes(setup)
    worst, lost, odd = 0.0, np.zeros(len(COMPARED_VEHICLES), dtype=bool), ""
    for index, (axis, amplitude) in enumerate(PAPER_STEPS):
        settled = [decay.of(axis, {}, each) for each in COMPARED_VEHICLES]
        flown = engine.fly(
            [{}] * len(COMPARED_VEHICLES),
            axis,
            amplitude,
            duration=max(map(step_duration, settled)),
            variations=COMPARED_VEHICLES,
        )
        gone = np.isfinite(flown.diverged_at)
        # a drone that is heavier than its controller knows sinks before the edge
        response = flown.response - flown.response[:, :1]
        decay_times = flown.decay_times(settled)
        known = step_metrics(flown.time, response, amplitude, decay=decay_times)
        lost |= gone
        worst = max(worst, float(known.overshoot[~gone].max(initial=0.0)))
        if wrong := int((amplitude * response[~gone, -1] <= 0.0).sum()):
            odd = f"with {wrong} of the 8 vehicles the {axis} step goes the wrong way"
        elif slow := int(np.isnan(known.overshoot[~gone]).sum()):
            odd = f"with {slow} of the 8 vehicles the {axis} step does not settle"
        bench.say((index + 1) / len(PAPER_STEPS))
    bench.found.note("lost", float(lost.sum()))
    if odd:
        bench.found.none(["worst_overshoot"], odd)
    else:
        bench.found.note(
            "worst_overshoot", worst, "of those that are not lost" if lost.any() else ""
        )


def _measure_margins(bench: ComparisonBench) -> None:
    steering, holding = bench.study.sampled(), bench.study.sampled(HOLDING_POINT)
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
    both = [
        multiloop_margin(bench.study.plant_input(point)) for point in (HOVER_POINT, HOLDING_POINT)
    ]
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


PART_MEASURES: Mapping[str, Callable[[ComparisonBench], None]] = {
    "steps": _measure_steps,
    "path": _measure_path,
    "push": _measure_push,
    "upside_down": _measure_upside_down,
    "wind": _measure_wind,
    "vehicles": _measure_vehicles,
    "margins": _measure_margins,
}


def _distance_from(flight: Recording, place: np.ndarray) -> np.ndarray:
    """Return the distance (N) of a flight from a place (3), or from one at every time (N, 3)."""
    return np.asarray(np.linalg.norm(flight.p_WB - place, axis=1))


def _for_good(time: np.ndarray, good: np.ndarray) -> float:
    """Return the time from which all samples are good [s], NaN if the last one is not."""
    bad = np.flatnonzero(~good)
    if not len(bad):
        return float(time[0])
    return float(time[bad[-1] + 1]) if bad[-1] + 1 < len(time) else math.nan
