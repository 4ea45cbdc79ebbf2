"""Oracle: the same flight on the two diagrams that are made of one chain."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.diagram import make_flight_core, make_open_loop, make_workbench
from workbench.gains import vehicle_gains
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.placing import place_vehicle
from workbench.resources import find_model
from workbench.scenario import Action, Rates, Scenario, Start
from workbench.session import Session
from workbench.systems.cascade import Guidance, Reference
from workbench.systems.rotor_playback import RotorCommands

HEIGHT = 10.0


@pytest.fixture(scope="module")
def description():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="module")
def vehicle(description):
    return make_vehicle(description)


@pytest.fixture(scope="module")
def gains(vehicle):
    return vehicle_gains(vehicle)


@pytest.fixture(scope="module")
def core(description, vehicle, gains):
    return make_flight_core(description, vehicle, gains)


def sizes(ports) -> dict[str, int]:
    return {port.get_name(): port.size() for port in ports}


def test_the_core_has_the_ports_it_names(core):
    inputs = [core.get_input_port(i) for i in range(core.num_input_ports())]
    outputs = [core.get_output_port(i) for i in range(core.num_output_ports())]
    assert sizes(inputs) == {"reference": 8, "guidance": 9}
    assert sizes(outputs) == {"state": 13, "thrusts": 4, "speeds": 4}


def test_the_core_has_one_kind_of_time(core):
    """Twenty continuous states: the body, four rotors, the estimate; so `Linearize` is exact."""
    context = core.CreateDefaultContext()
    assert context.num_continuous_states() == 13 + 4 + 3
    assert context.num_total_states() == context.num_continuous_states()


def test_hover_is_an_equilibrium_of_the_core(core, vehicle):
    context = core.CreateDefaultContext()
    core.GetInputPort("reference").FixValue(context, np.zeros(8))
    guide = Guidance(1, 1, 1, 0, 1, 1, 0, 0, HEIGHT)
    core.GetInputPort("guidance").FixValue(context, np.array(guide, dtype=float))
    state = [1, 0, 0, 0, 0, 0, HEIGHT, *[0.0] * 6, *vehicle.hover_speeds, 0, 0, 0]
    context.SetContinuousState(state)
    derivatives = core.EvalTimeDerivatives(context).CopyToVector()
    assert derivatives == pytest.approx(np.zeros(20), abs=1e-9)


def core_flight(core, vehicle, reference, times) -> np.ndarray:
    """Return state over time of the continuous core under a reference, from hover."""
    simulator = Simulator(core)
    context = simulator.get_mutable_context()
    core.GetInputPort("reference").FixValue(context, np.array(reference, dtype=float))
    guide = Guidance(1, 1, 1, 0, 0, 0, 0, 0, HEIGHT)
    core.GetInputPort("guidance").FixValue(context, np.array(guide, dtype=float))
    start = [1, 0, 0, 0, 0, 0, HEIGHT, *[0.0] * 6, *vehicle.hover_speeds, 0, 0, 0]
    context.SetContinuousState(start)
    simulator.get_mutable_integrator().set_target_accuracy(1e-6)
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(core.GetOutputPort("state").Eval(context).copy())
    return np.array(states)


@pytest.mark.parametrize(
    ("reference", "bound"),
    [
        (Reference(2.0, 0, 0, 0, 0, 0, 0, 0), 0.045),
        (Reference(0, 0, 1.0, 0, 0, 0, 0, 0), 0.012),
        (Reference(0, 0, 0, 0.2, 0, 0, 0, 0), 0.0025),
        (Reference(1.0, -1.0, 0.5, 0.1, 0, 0, 0, 0), 0.03),
    ],
)
def test_the_workbench_flies_as_the_core_does(core, vehicle, reference, bound):
    """A step, sampled at the default rates and continuous.

    A hold is a delay of half a control period, 4 ms, and a stepped plant half a step more. On a
    slope of 6.5 m/s² that is 28 mm/s while x rises (37 are seen, as a delay also stirs the loop),
    on 2.5 m/s² 11 mm/s of z (8 are seen), on 0.5 rad/s² 2 mrad/s of yaw. In the end they agree.
    """
    scenario = Scenario(
        duration=2.0,
        start=Start(position=[0.0, 0.0, HEIGHT]),
        script=[Action(at=0.0, velocity=list(reference[:3]), yaw_rate=reference.yaw_rate)],
    )
    session = Session(scenario)
    session.run()
    flight = session.recording()
    states = core_flight(core, vehicle, reference, flight.time)
    velocity = np.column_stack([flight.v_WB, flight.w_WB[:, 2]])
    wanted = np.column_stack([states[:, 10:13], states[:, 9]])
    assert wanted[-1] == pytest.approx(reference[:4], abs=0.02)
    assert np.abs(velocity - wanted).max() < bound
    assert velocity[-1] == pytest.approx(wanted[-1], abs=0.001)


def test_the_workbench_has_every_system_of_the_parameter_table(description, vehicle, gains):
    bench = make_workbench(description, vehicle, gains, Rates())
    names = {system.get_name() for system in bench.diagram.GetSystems()}
    assert {"plant", "controller", "modes", "battery", "pilot", "request"} <= names
    assert "path" not in names
    assert bench.diagram.num_input_ports() == 0


def test_the_open_loop_hovers_on_hover_thrust(description, vehicle):
    """Two seconds; then one rotor gives up and it tumbles."""
    hover = vehicle.hover_speeds
    commands = RotorCommands(np.array([0.0, 2.0]), np.array([hover, [0.0, *hover[1:]]]))
    bench = make_open_loop(description, vehicle, Rates(), commands)
    simulator = Simulator(bench.diagram)
    context = simulator.get_mutable_context()
    plant, rotors = bench.airframe.plant, bench.rotors
    rotors.set_rotors(rotors.GetMyMutableContextFromRoot(context), hover)
    place_vehicle(
        plant,
        plant.GetMyMutableContextFromRoot(context),
        vehicle,
        p_WB=[0, 0, HEIGHT],
        roll_pitch_yaw=[0, 0, 0],
        v_WB=[0, 0, 0],
        w_WB=[0, 0, 0],
    )
    simulator.AdvanceTo(2.0)
    assert bench.recorder.now(context)["state"][4:7] == pytest.approx([0, 0, HEIGHT], abs=1e-6)
    simulator.AdvanceTo(2.5)
    assert np.linalg.norm(bench.recorder.now(context)["state"][7:10]) > 5.0
