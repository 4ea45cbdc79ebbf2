"""Margins are true of what flies: just inside of them disturbances die out, just outside they grow.

The full diagram is flown with the gain of one loop scaled, or with its signal late. A delay that is
no whole number of control periods is interpolated between samples, which at the frequencies where
these loops cross turns the phase as the delay does, and changes the size by less than a percent.
"""

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import LawSetpoint
from workbench.control.installed_laws import DEFAULT_CONTROLLER, installed_laws
from workbench.control.law_constants import law_constants
from workbench.design.judge.margins import loop_margins
from workbench.design.judge.modes import modes
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, ScenarioStart, SensorsConfig, VehicleConfig
from workbench.session.session import Session
from workbench.systems.acceleration_estimate import sampled_estimate

SMALL = 1e-7
"""Of the disturbance, so that rotors answer linearly [m/s, rad/s, N]."""
TURNS = {"x": 1, "y": 0, "yaw": 2}
"""Components of the angular velocity in which a loop is seen to swing: loops that are much faster
than the velocity above them hardly move it."""
WINDOW = 1.0
"""Over which a swing is taken, or over a whole one of a slow loop [s]."""
GROWN = 30.0
FILTERED = {
    "gyro_lowpass": 60.0,
    "gyro_notch": 110.0,
    "gyro_rate": 512.0,
    "derivative_lowpass": 20.0,
}
"""Filters of a flight whose margins they take."""
STEADY = 5
"""Windows over which swings grow, or shrink, one after the other, when that is decided."""
MOST = 40
"""Windows before growth or decay by this factor must have shown."""
NOTHING: dict[str, float] = {}
OWN = ("pitch", "velocity_x", "velocity_z", "yaw_rate", "position_x")
"""Loops of the default law, one of each kind: of those that differ in the axis alone, one."""
FAST = {
    "crazyflie": "pitch_rate",
    "mellinger": "velocity_x",
    "px4": "pitch_rate",
    "ardupilot": "pitch_rate",
    "betaflight": "pitch_rate",
}
"""The loop of another law that is flown, if it is not that of pitch: one that swings fast. Climb by
LQI and by `mellinger` is as large as rotors let it become before it can be seen to grow; that of
laws with slow parts is in `design/linear/test_slow_parts.py`."""


ALL_LAWS = installed_laws()


def each_loop(names=OWN, laws=(DEFAULT_CONTROLLER,), quick=()):
    """Let a test fly loops of the default law, and a fast one of each other law.

    Args:
        names: of loops of the default law.
        laws: names of laws.
        quick: which of the named loops are no slow test.
    """
    rows = []
    for law in map(load_controller, laws):
        own = law.name == DEFAULT_CONTROLLER
        for name in names if own else [FAST.get(law.name, "pitch")]:
            marks = () if own and name in quick else pytest.mark.slow
            rows.append(pytest.param(law, name, marks=marks, id=f"{law.name}-{name}"))
    return pytest.mark.parametrize(("law", "loop"), rows, indirect=True)


@pytest.fixture(scope="module")
def law(request):
    return getattr(request, "param", None) or load_controller()


@pytest.fixture
def loop(law, request):
    return law.loop(request.param)


@pytest.fixture(scope="module")
def margins(law):
    study = LinearStudy(Scenario(controller=law.name))
    models = {hold: study.sampled(OperatingPoint(hold=hold)) for hold in (False, True)}
    return {
        loop.name: loop_margins(models[loop.hold], loop.point("actuator")) for loop in law.loops
    }


@pytest.fixture(scope="module")
def session(law):
    """Far from ground and ceiling."""
    start = ScenarioStart(position=[0.0, 0.0, 60.0])
    return Session(Scenario(controller=law.name, start=start, duration=1000.0))


class FlownLoop:
    """A flight in which one loop's signal goes on scaled or late."""

    def __init__(self, session, loop, gain, delay, settings, crossover):
        self.session, self.loop = session, loop
        self.window = self.period * round(max(WINDOW, 2.0 * np.pi / crossover) / self.period)
        points = session.controller.point_names
        self.place, self.delay = points.index(loop.point("actuator")), delay / self.period
        self.count = len(points)
        session.reset()
        for name, value in settings.items():
            session.set(name, value)
        self.computer = session._bench.computer
        self.context = self.computer.GetMyMutableContextFromRoot(
            session._live.simulator.get_mutable_context()
        )
        self.constants = law_constants(session.vehicle)
        self.past = [self.signal()]
        probes = self.context.get_mutable_numeric_parameter(self.computer.probes_index)
        probes.SetAtIndex(self.place, 0.0 if delay else gain)
        self.disturb()

    def disturb(self):
        if self.loop.hold:
            self.session.push([SMALL * (self.axis == each) for each in "xyz"], duration=0.1)
        elif self.axis == "yaw":
            self.session.command(yaw_rate=SMALL)
        else:
            self.session.command([SMALL * (self.axis == each) for each in "xyz"])

    @property
    def period(self) -> float:
        """Between control updates [s]."""
        return self.session.scenario.rates.control_period

    @property
    def axis(self) -> str:
        """What moves with the loop: x, y, z or yaw."""
        name = self.loop.name
        return {"pitch": "x", "pitch_rate": "x", "roll": "y", "yaw_rate": "yaw"}.get(name, name[-1])

    def signal(self) -> float:
        """Return what comes to the loop point now, of the pure law with what the computer sees."""
        state, reference, guidance = (
            self.computer.GetInputPort(name).Eval(self.context).tolist()
            for name in ("state", "reference", "guidance")
        )
        setpoint = LawSetpoint(reference, guidance, [0.0] * 3)
        gains, probes = (
            self.context.get_numeric_parameter(index).value().tolist() for index in range(2)
        )
        law = self.session.controller
        commands, filtered, memory = (
            self.context.get_discrete_state(index).value().tolist()
            if index < 2 or law.memory
            else []
            for index in range(3)
        )
        loops = [*probes, *[0.0] * self.count]
        estimate = sampled_estimate(self.period)
        flight_law(law).update(
            state,
            1.0,
            setpoint,
            gains,
            self.constants,
            loops,
            estimate,
            self.context.get_numeric_parameter(self.computer.settings_index).value().tolist(),
            filtered,
            memory,
            commands,
        )
        return loops[2 * self.count + self.place]

    def swing(self) -> float:
        """Fly on for a while and return the largest change of what moves from sample to sample."""
        begin = self.session.time
        if self.delay:
            for _ in range(round(self.window / self.period)):
                self.pass_on_late()
                self.session.tick(self.period)
        else:
            self.session.tick(self.window)
        flown = self.session.recording().between(begin, np.inf)
        moved = flown.v_WB[:, 2] if self.axis == "z" else flown.w_WB[:, TURNS[self.axis]]
        return np.abs(np.diff(moved)).max()

    def pass_on_late(self) -> None:
        self.past.append(self.signal())
        whole = int(self.delay)
        share = self.delay - whole
        early, late = (self.past[max(-len(self.past), -1 - whole - i)] for i in (0, 1))
        probes = self.context.get_mutable_numeric_parameter(self.computer.probes_index)
        probes.SetAtIndex(self.count + self.place, (1.0 - share) * early + share * late)


def check(session, loop, found, gain, delay, settings=NOTHING) -> bool:
    """Fly until the swing has grown or shrunk, and return whether it grows."""
    flown = FlownLoop(session, loop, gain, delay, settings, found.crossover)
    flown.swing()  # the disturbance itself goes by
    swings = [flown.swing()]
    while len(swings) < MOST and swings[0] / GROWN < swings[-1] < GROWN * SMALL:
        swings.append(flown.swing())
        ways = np.sign(np.diff(swings))[-STEADY:]
        if len(ways) == STEADY and np.ptp(ways) == 0.0:
            break
    # what grows fast is as large as rotors let it become, maybe within the first window
    return bool(swings[-1] > swings[0] or swings[-1] > GROWN * SMALL)


@each_loop(laws=ALL_LAWS, quick=["pitch"])
def test_the_gain_margin_is_where_the_flight_begins_to_diverge(session, margins, loop):
    found = margins[loop.name]
    assert not check(session, loop, found, 0.99 * found.gain_margin, 0.0)
    assert check(session, loop, found, 1.01 * found.gain_margin, 0.0)


@each_loop(("pitch", "position_x"), [law for law in ("pd", "px4") if law in ALL_LAWS])
def test_the_delay_margin_is_where_the_flight_begins_to_diverge(session, margins, loop):
    found = margins[loop.name]
    assert not check(session, loop, found, 1.0, 0.95 * found.delay_margin)
    assert check(session, loop, found, 1.0, 1.05 * found.delay_margin)


@each_loop(("pitch", "velocity_z"))
def test_so_it_is_with_filters_on_the_way(session, margins, loop):
    """The gain margin of one loop and the delay margin of another; less is left than without."""
    model = LinearStudy(Scenario(controller=session.controller.name)).sampled(gains=FILTERED)
    found = loop_margins(model, loop.point("actuator"))
    assert found.gain_margin < 0.95 * margins[loop.name].gain_margin
    if loop.name == "velocity_z":
        assert not check(session, loop, found, 1.0, 0.95 * found.delay_margin, FILTERED)
        assert check(session, loop, found, 1.0, 1.05 * found.delay_margin, FILTERED)
    else:
        assert not check(session, loop, found, 0.99 * found.gain_margin, 0.0, FILTERED)
        assert check(session, loop, found, 1.01 * found.gain_margin, 0.0, FILTERED)


@each_loop(["pitch"])
def test_so_it_is_on_an_estimate_of_the_motion(law, loop):
    """Behind filters, with an EKF on samples of all sensors that come at their own rates.

    Sensors have no noise, which would hide what is small. The model spreads samples over updates.
    """
    start = ScenarioStart(position=[0.0, 0.0, 60.0])
    scenario = Scenario(
        controller=law.name,
        estimator="ekf",
        start=start,
        duration=1000.0,
        sensors=SensorsConfig(noise=False),
    )
    session = Session(scenario)
    model = LinearStudy(scenario).sampled(gains=FILTERED)
    found = loop_margins(model, loop.point("actuator"))
    for gain, delay, grows in (
        (0.99 * found.gain_margin, 0.0, False),
        (1.01 * found.gain_margin, 0.0, True),
        (1.0, 0.95 * found.delay_margin, False),
        (1.0, 1.05 * found.delay_margin, True),
    ):
        assert check(session, loop, found, gain, delay, FILTERED) == grows, (gain, delay)


@each_loop(["pitch"])
def test_a_weaker_tilt_loop_diverges_under_its_velocity_loop(session, margins, loop):
    found = margins[loop.name]
    assert found.gain_reduction_margin > 0.0
    assert not check(session, loop, found, 1.01 * found.gain_reduction_margin, 0.0)
    assert check(session, loop, found, 0.99 * found.gain_reduction_margin, 0.0)


@pytest.fixture(scope="module")
def slung(tmp_path_factory):
    """Return a scenario of a quadrotor with a load of a quarter of its mass, that swings."""
    hinge = link("load", 0.25, (0.0, 0.0, -0.8)) + joint(
        "swing", "universal", "base", "load", (0.0, 0.0, -0.1)
    )
    model = drone(tmp_path_factory.mktemp("slung"), hinge)
    start = ScenarioStart(position=[0.0, 0.0, 60.0])
    return Scenario(vehicle=VehicleConfig(model=model), start=start, duration=1000.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pitch", "velocity_x"])
def test_so_it_is_with_a_load_that_swings(slung, name):
    """Predicted from the model with the swing among its modes, and flown with the load."""
    study, session = LinearStudy(slung), Session(slung)
    model, loop = study.sampled(), session.controller.loop(name)
    joints = [signal for signal, _ in study.vehicle.small_joint_signals]
    swings = [mode for mode in modes(model, joints) if mode.joint.startswith("swing")]
    assert {mode.joint for mode in swings} == {"swing::1", "swing::2"}
    found = loop_margins(model, loop.point("actuator"))
    assert not check(session, loop, found, 0.97 * found.gain_margin, 0.0)
    assert check(session, loop, found, 1.03 * found.gain_margin, 0.0)


def test_a_normal_flight_has_all_gates_open_and_nothing_injected(session):
    session.reset()
    computer = session._bench.computer
    context = computer.GetMyContextFromRoot(session._live.root)
    probes = context.get_numeric_parameter(computer.probes_index).CopyToVector()
    assert probes == pytest.approx(session.controller.closed)
