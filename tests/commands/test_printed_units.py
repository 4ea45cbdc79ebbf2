"""Tables of commands for people: each number in the unit and under the label that stand with it.

The records are made by hand, so nothing flies, and no two of their numbers are equal.
"""

import argparse
import math
import re
from types import SimpleNamespace as Record

import numpy as np
import pytest

from workbench.commands import (
    description_tables,
    estimate,
    exchange_report,
    flight_report,
    hover,
    judgement_tables,
    lidar_trial,
    linearize,
    log,
    new,
    step,
    sweep,
    translated_gains,
    tune,
)
from workbench.design.estimation_errors import EstimateReport, Innovations, Nees, StateError
from workbench.design.flight_summary import FlightSummary
from workbench.design.judge.margins import LoopMargins
from workbench.design.judge.multiloop import MultiloopMargin
from workbench.design.judge.noise import NoiseEffect
from workbench.design.judge.phase_budget import PhaseBudget
from workbench.design.judge.sampled_stability import SlowestRate
from workbench.design.load_metrics import LoadMetrics
from workbench.design.metrics import Demand, find_metric
from workbench.design.obstacle_detection import Detection
from workbench.design.step_metrics import STEP_NUMBERS
from workbench.design.translate.loop_difference import LoopDifference

DEG = math.pi / 180.0
ARGS = argparse.Namespace(gains=None, set=[], vary=[], loop="pitch", at="hover", load=None)
MARGINS = LoopMargins(2.0, 0.5, 45.0 * DEG, 0.02, 0.7, 1.5, 10.0, 20.0)
OTHERS = LoopMargins(3.0, 0.4, 60.0 * DEG, 0.03, 0.8, 1.4, 11.0, 22.0)


def metrics(first):
    """Metrics of a step that count upwards from a number, in the order of the table."""
    numbers = {name: first + index for index, name in enumerate(STEP_NUMBERS)}
    return Record(**numbers, withheld="")


def estimate_report():
    states = (
        StateError("roll", "rad", 1.0 * DEG, 2.0 * DEG),
        StateError("w_x", "rad/s", 3.0 * DEG, 6.0 * DEG),
        StateError("x", "m", 0.5, 2.5),
        StateError("charge", "1", 0.25, 0.75),
    )
    channels = (Innovations("gps_x", 40, 0.96, 1.1, "ekf_gps_position"),)
    estimate.print_estimate(EstimateReport(states, Nees(9, 9.5, 2.7, 19.0, 0.875), channels))


def flight():
    summary = FlightSummary(
        **{"duration": 12.0, "distance": 34.0, "max_speed": 5.0, "max_height": 6.0},
        **{"min_height": 0.25, "end": (1.0, 2.0, 3.0), "max_tilt": 30.0 * DEG},
        **{"turned_over": None, "max_yaw_rate": 90.0 * DEG, "max_rotor_use": 0.8},
        **{"final_mode": "hovering", "battery_used": 0.35, "touch_down_speed": 0.4},
        **{"least_clearance": 0.7, "slack_time": 1.5},
    )
    sensor = Record(name="down", kind="range_finder", asked_rate=50.0, rate=49.5, age=0.02)
    for row in (*flight_report._lines(summary), *flight_report._sensor_lines((sensor,))):
        print(*row)


def hover_check():
    demands = (
        Demand("hover", "tilt", "rad", 0.25 * DEG, 0.5 * DEG),
        Demand("hover", "drift", "m", 0.03, 0.02),
    )
    steps = (Record(axis="x", peak_rotor_use=0.62), Record(axis="yaw", peak_rotor_use=0.47))
    vehicle = Record(name="quad", mass=1.5, rotors=(1, 2, 3, 4), source="quad.urdf")
    report = Record(
        hover=Record(vehicle=vehicle), demands=demands, steps=steps, rotor_use=0.41, exchange={}
    )
    hover._print_hover(report, Record(), {}, [])


def judged():
    print("cells", *judgement_tables._cells(MARGINS))
    budget = PhaseBudget(
        "pitch", 2.0 * math.pi, *(-each * DEG for each in (90.0, 11.0, 12.0, 13.0, 14.0, 15.0))
    )
    effects = (NoiseEffect("gyro", (1.0 * DEG, 2.0 * DEG, 3.0 * DEG), (0.01, 0.04)),)
    pair = Record(axis="x", linear=metrics(1.0), flown=metrics(11.0), broken="")
    held = MultiloopMargin(0.5, 7.0, {"z": 0.9, "roll": 0.6})
    found = Record(
        phase=(budget,),
        noise=effects,
        steps=(pair,),
        plant_input=MultiloopMargin(1.0, 5.0, {"z": 1.2, "roll": 1.1}),
        plant_input_holding=held,
    )
    judgement_tables._print_phase(found)
    judgement_tables._print_noise(found)
    judgement_tables._print_steps(found)
    judgement_tables._print_plant_input(found)
    slowest = SlowestRate(0.02, 0.005, (Record(period=0.001), Record(period=0.1)))
    print(judgement_tables._rates(slowest))
    mode = Record(
        real=-1.5, imaginary=2.0, damping=0.6, frequency=2.5, time_constant=0.667, joint="arm"
    )
    judgement_tables.print_modes((mode,))


def lidar():
    print(
        *lidar_trial._errors(
            "ball", Record(returns=7, bias=0.001, rmse=0.002, percentile_95=0.003, maximum=0.004)
        )
    )
    print(*lidar_trial._detection_line(Detection("ball", False, 1.25, 9.0, 1.375, 8.5)))
    timing = Record(
        **{"median_age": 0.006, "maximum_age": 0.0075, "delivered": 19, "late": 1},
        **{"expected": 20, "share_on_time": 0.9, "rate": 9.75},
    )
    flown = Record(asked_rate=10.0, computing_time=0.0123)
    nearest = Record(obstacle="crate", distance=1.75, time=3.5)
    lidar_trial._print_response(Record(response=timing, flight=flown, clearance=nearest, reach=0.0))
    print(*lidar_trial._demand_line(Demand("accuracy", "mean_error", "m", 0.0015, 0.0025)))


def linear_model():
    matrices = Record(
        dt=0.0125, A=np.diag([0.9, 0.8]), poles=np.array([0.9 + 0j, 0.8 + 0j]),
        state_labels=["a", "b"], input_labels=["u"], output_labels=["y"],
    )  # fmt: skip
    linearize._print(matrices, [], ARGS)


def loop_measured():
    row = {
        **{"frequency": 5.0, "coherence": 0.95, "deviation": 1.0},
        **{"measured_size": 10.0, "measured_phase": 60.0 * DEG},
        **{"model_size": 0.1, "model_phase": -30.0 * DEG},
    }
    linearize._print_measurement(
        Record(
            **{"vehicle": "quad", "loop": "pitch", "cut": "actuator"},
            injection=Record(size=0.25, point="moment", lowest=math.pi),
            measured=Record(periods=7),
            margins=MARGINS,
            rows=lambda: [row],
            worst=lambda: (1.25, 8.0 * DEG),
        )
    )


def log_contents():
    signal = Record(
        name="imu.f_x", unit="m/s^2", rate=200.0, time=np.array([0.5, 9.5]),
        gaps=[(1.0, 1.25), (2.0, 4.5)],
    )  # fmt: skip
    flown = Record(
        **{"name": "made", "format": "CSV", "firmware": "", "end": 10.0},
        **{"signals": {"imu.f_x": signal}, "parameters": {}, "remarks": ()},
    )
    offset = Record(later="gps", earlier="imu", offset=0.012, correlation=0.83)
    contents = Record(
        turning=8.0, saturated=0.35, offsets=(offset,), findable=(), loops=("roll_rate",)
    )
    contents.findable = (Record(what="mass", can=True, why="thrusts"),)
    log._print(flown, contents, False)


def new_drone():
    rotors = (Record(max_rot_velocity=1000.0), Record(max_rot_velocity=1000.0))
    for rotor in rotors:
        rotor.moment_constant = rotor.motor_constant = 1.0
    vehicle = Record(
        name="quad", mass=1.5, rotors=rotors, hover_speeds=np.array([500.0, 600.0]),
        thrust_to_weight=2.78,
    )  # fmt: skip
    sheet = Record(rotors=2, layout="x", arm=0.225, propeller=Record(label="10x4.5"))
    found = [Record(name="hover_duration", value=720.0, unit="s", source="given")]
    new._print("quad.urdf", sheet, found, vehicle)


def steps():
    recording = Record(vehicle=Record(name="quad"))
    load = LoadMetrics(0.05, 0.3, 1.2, 2.5)
    step._print_load(
        Record(load="force_x", amplitude=0.5, recording=recording, metrics=load,
               peak_rotor_use=0.57, exchange={}), ARGS, "",
    )  # fmt: skip
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(step.dataclasses, "asdict", vars)
        step._print_command(
            Record(axis="x", amplitude=1.0, recording=recording, metrics=metrics(1.0),
                   coupling=Record(x=0.1, y=0.2, z=0.3, yaw=0.4), peak_rotor_use=0.63,
                   exchange={}), ARGS, "",
        )  # fmt: skip


def metrics_of_a_sweep():
    for name, value in (("phase_margin", 45.0 * DEG), ("overshoot", 12.0)):
        print(name, sweep._text(find_metric(name), value))


def translation():
    found = Record(gains=(), lost_in=lambda _: (), lost=(), remarks=(), exact=True)
    flown = (LoopDifference("roll", 20.0, 21.0, 0.12, 3.0),)
    alone = (LoopDifference("roll", 20.5, 21.5, 0.034, 4.0),)
    translated_gains._print_translation("made", found, flown, alone)


def margins_before_and_after():
    exchange_report.print_margins({"pitch": MARGINS}, {"pitch": OTHERS})


def described():
    rotors = tuple(
        Record(
            max_rot_velocity=1000.0, rotor_drag_coefficient=0.0, rolling_moment_coefficient=0.0,
            linear_motor_constant=0.0, inflow_coefficient=0.0, ground_effect_coefficient=0.0,
        )
        for _ in range(2)
    )  # fmt: skip
    inertia = np.array([[1.0, 4.0, 5.0], [4.0, 2.0, 6.0], [5.0, 6.0, 3.0]])
    battery = Record(
        open_circuit_voltage=((0.0, 9.0), (1.0, 12.5)), capacity=18000.0, hover_duration=720.0,
        sag_compensation=0.75, resistance=0.02,
    )  # fmt: skip
    vehicle = Record(
        mass=1.5, p_BoBcm_B=np.array([0.1, 0.2, 0.3]), base_link="base", inertia=inertia,
        hover_speeds=np.array([500.0, 600.0]), rotors=rotors, thrust_to_weight=2.78,
        battery=battery, ground_clearance=0.125,
    )  # fmt: skip
    for row in description_tables._body(vehicle):
        print(*row)


def tuning():
    wish = Record(
        name="pitch.phase_margin", file_name="pitch.phase_margin_deg", at_least=True, origin="",
        metric=find_metric("phase_margin"),
    )  # fmt: skip
    required = Record(
        wish=wish, bound=40.0 * DEG, case="nominal", widened=None, met=lambda value: value > 0.5
    )
    progress = Record(
        phase="searching", worst=required, value=50.0 * DEG, best=Record(reserve=0.25)
    )
    print(tune.progress_line(progress))
    conflict = Record(wish=wish, against=(), required=required, nearest=35.0 * DEG)
    found = Record(
        vehicle="quad", met=False, stopped=False, evaluations=9, shortfalls=(), remarks=(),
        controller=Record(name="pd"), results=(), guarded=(), before={"kp_roll": 1.0},
        gains={"kp_roll": 2.0}, proof=Record(values=((required, 55.0 * DEG),)),
        conflicts=(conflict,),
    )  # fmt: skip
    result = tune.tuning_json(found)
    (proof,), (nearest,), gains = result["proof"], result["conflicts"], result["gains"]
    print("proof", *(f"{proof[name]:.6g}" for name in ("bound", "flown")), proof["met"])
    print("conflict", *(f"{nearest[name]:.6g}" for name in ("bound", "nearest")))
    print("gain", gains["kp_roll"]["before"], gains["kp_roll"]["after"])


TABLES = {
    estimate_report: """
        roll 1.000 2.000 deg
        w_x 3.000 6.000 deg/s
        x 0.500 2.500 m
        charge 25.000 75.000 %
        mean 9.50 of 9 states, 87.5 % of the time within 2.70 .. 19.00 (95 %)
        gps_x 40 96.0 %
    """,
    flight: """
        duration 12.00 s
        distance 34.00 m
        max speed 5.00 m/s
        max height 6.00 m
        lowest height 0.25 m
        end 1.00 2.00 3.00 m
        max tilt 30.0 deg
        max yaw rate 90.0 deg/s
        max rotor use 80.0 % of the speed limit
        battery used 35.0 %
        least clearance 0.70 m
        slack cable 1.50 s
        touch-down speed 0.40 m/s
        down range finder 50 49.50 20
    """,
    hover_check: """
        quad, 1.5 kg, 4 rotors: quad.urdf
        hover: tilt 0.250 0.5 deg ok
        hover: drift 0.030 0.02 m not ok
        of its limit: hover 41 %, x step 62 %, yaw step 47 %
    """,
    judged: """
        cells 2 0.5 45.0 20.0 0.70 1.50 10 20
        loop at [rad/s] at [Hz] law filters estimator delay hold rotors phase of L
        pitch 6.28 1 -90.0 -11.0 -12.0 -13.0 -14.0 -15.0 -155.0
        roll [deg] pitch [deg] yaw [deg] commands [% of their mean]
        gyro 1 2 3 4
        x linear flown
        rise_time 1 11
        settling_time 2 12
        while the pilot steers 1.00 0.33 .. 3.00 5 1.20 1.10
        while the position is held 0.50 0.60 .. 1.67 7 0.90 0.60
        stable down to 50.0 Hz and keeps 30 deg of phase margin down to 200.0 Hz
        -1.5 ± 2i 0.600 2.5 0.667 arm
    """,
    lidar: """
        ball 7 1.000 2.000 3.000 4.000
        ball 1.250 s 9.00 m 1.375 s 8.50 m 125.0 ms
        age: median 6.0 ms, most 7.5 ms
        on time: 18 of 20 scans (90.0 %)
        rate: 9.750 Hz, where 10 Hz is asked for
        takes 12.3 ms on this machine now
        came within 1.75 m of crate (base link, at 3.5 s)
        accuracy: mean error 1.500 2.500 mm ok
    """,
    linear_model: """
        pitch at hover, sampled each 12.5 ms, with its own gains: 2 states
        -8.429 1.000 8.429 0.119
    """,
    loop_measured: """
        0.25 rms injected at moment, 7 periods of 2 s measured
        5 0.95 20.00 60.0 6.02 -20.00 -30.0 40.00 90.0
        bandwidth, 10 rad/s
        differ by 1.25 dB and 8.0 deg
    """,
    log_contents: """
        motors turn for 8.0 s, one of them at its limit in 35 % of it
        imu f_x m/s^2 200.0 0.50 9.50 2 2.50
        stream behind by [ms] correlation
        gps imu +12 0.83
        mass yes thrusts
        step responses: roll_rate
    """,
    new_drone: """
        quad: 1.5 kg, 2 rotors (x) 0.225 m from the centre, propellers 10x4.5
        hover_duration 720 s given
        thrust to weight 2.78
        hover throttle 60 % of the largest speed, 36 % of the largest thrust
        hover time about 12 min
    """,
    steps: """
        step of 0.5 N
        peak 0.05 m of the
        peak_time 0.300 s
        settling_time 1.200 s
        steady_state_error 2.500 %
        peak_rotor_use 57.0 % of the speed limit
        step of 1 m/s along x, quad with its own gains
        rise_time 1.000 s
        settling_time 2.000 s
        overshoot 3.00 %
        undershoot 4.00 %
        peak 5.0000 m/s
        peak_time 6.000 s
        steady_state_value 7.0000 m/s
        steady_state_error 8.000 %
        peak_rotor_use 63.0 % of the speed limit
        coupling y 0.2000 m
        coupling z 0.3000 m
        coupling yaw 0.4000 rad
    """,
    metrics_of_a_sweep: """
        phase_margin 45
        overshoot 12
    """,
    translation: """
        loop crossover [rad/s] new as flown gains alone
        roll 20 21 12 % 3.4 %
    """,
    margins_before_and_after: """
        loop phase margin [deg] gain margin crossover [rad/s]
        pitch 45 60 2 3 20 22
    """,
    described: """
        mass 1.5 kg
        moments of inertia 1 2 3 kg m² about x, y, z
        products of inertia 4 5 6 kg m² xy, xz, yz
        thrust to weight 2.78
        hover speed 500 rad/s (50 %), 600 rad/s (60 %)
        battery 1.8e+04 C, 12.5 V full, 9 V empty, 0.02 ohm, hovers 12 min, 75 % of its sag
        ground clearance 0.125 m from base
    """,
    tuning: """
        best so far: pitch.phase_margin 50 deg (+25 % to spare)
        proof 40 55 True
        conflict 40 35
        gain 1.0 2.0
    """,
}


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.__name__)
def test_people_read_each_number_in_its_unit(table, capsys):
    """The lines stand in this order; blanks between columns do not count."""
    table()
    printed = re.sub(r"\s+", " ", capsys.readouterr().out.replace("'", ""))
    at = 0
    for line in table_lines(TABLES[table]):
        place = printed.find(line, at)
        assert place >= 0, f"'{line}' does not stand in: {printed}"
        at = place + len(line)


def table_lines(text):
    return [" ".join(line.split()) for line in text.strip().splitlines()]
