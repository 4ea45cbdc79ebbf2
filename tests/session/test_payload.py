"""A payload as live parameters. Oracles: closed forms, and a description that has it as a link."""

import shutil
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.linear.derivatives import Derivatives
from workbench.design.linear.flight_derivatives import FlightDerivatives
from workbench.design.linear.operating_point import HOVER_POINT, OperatingPoint
from workbench.design.linear.sampled_model import sampled_model
from workbench.design.linear.study import REMOVABLE, LinearStudy
from workbench.design.linear.trim import find_trim
from workbench.design.rollout.engine import RolloutEngine
from workbench.diagram.core import make_flight_core
from workbench.plant.description import Description, read_description
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import NO_PAYLOAD
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.setup import Setup
from workbench.systems.acceleration_estimate import sampled_estimate

UNEVEN = Path(__file__).parents[1] / "oracles/uneven_quad.urdf"
MASS = 0.4
CARRIED = {
    "payload_mass": MASS,
    "payload_x": 0.05,
    "payload_y": -0.03,
    "payload_z": -0.12,
    "payload_size_x": 0.1,
    "payload_size_y": 0.06,
    "payload_size_z": 0.2,
}
KNOWN = {"known_payload_mass": MASS}
LINK = """
  <link name="parcel"><inertial><mass value="0.4"/>
    <inertia ixx="{xx!r}" iyy="{yy!r}" izz="{zz!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="held" type="fixed"><parent link="base_link"/><child link="parcel"/>
    <origin xyz="0.05 -0.03 -0.12"/></joint>
</robot>
"""
LYING = VehicleConfig(str(UNEVEN))


@pytest.fixture(scope="module")
def welded(tmp_path_factory) -> Path:
    """Return a description of the uneven drone that has the payload as a link."""
    folder = tmp_path_factory.mktemp("welded")
    shutil.copy(UNEVEN.with_name("uneven_quad.rotors.yaml"), folder)
    x, y, z = 0.1**2, 0.06**2, 0.2**2
    link = LINK.format(xx=MASS / 12 * (y + z), yy=MASS / 12 * (x + z), zz=MASS / 12 * (x + y))
    path = folder / UNEVEN.name
    path.write_text(UNEVEN.read_text().replace("</robot>", link))
    return path


@dataclass(frozen=True, eq=False)
class Laden(Setup):
    """A setup of which another vehicle flies than its law knows.

    Attributes:
        laden: the description of what flies.
    """

    laden: Description

    @cached_property
    def flown(self) -> Description:
        return self.laden


def state(session) -> np.ndarray:
    return session.state().copy()


@pytest.mark.slow
@pytest.mark.parametrize("known", [0.0, 0.2, 0.4])
def test_the_error_of_height_is_the_weight_that_the_law_does_not_know(known):
    """Hover has no integral action: mass kp_position kp_velocity e = unknown mass g."""
    script = [Action(at=1.0, set={"payload_mass": 0.4, "known_payload_mass": known})]
    session = Session(
        Scenario(duration=16.0, start=ScenarioStart(position=[0, 0, 5]), script=script)
    )
    session.run()
    stiffness = session.get("kp_position_z") * session.get("kp_velocity_z")
    sag = (0.4 - known) * GRAVITY / ((session.vehicle.mass + known) * stiffness)
    assert 5.0 - state(session)[6] == pytest.approx(sag, abs=1e-3)
    assert np.abs(state(session)[7:]).max() < 1e-3


@pytest.mark.slow
def test_a_place_beside_the_middle_tilts_a_drone_whose_law_does_not_know_it():
    """And one whose law knows it hovers level, where it was."""
    beside = {"payload_mass": 0.3, "payload_x": 0.05, "payload_size_z": 0.1}
    for known, moves in ((0.0, True), (0.3, False)):
        session = Session(Scenario(start=ScenarioStart(position=[0.0, 0.0, 5.0])))
        session.do(Action(set={**beside, "known_payload_mass": known}))
        session.tick(8.0)
        found = state(session)
        assert (np.abs(found[4:6]).max() > 0.02) == moves
        assert (abs(found[6] - 5.0) > 0.02) == moves


@pytest.mark.parametrize(
    ("known", "at"),
    [({}, HOVER_POINT), ({}, OperatingPoint((2.0, -1.0, 0.5), 0.2)), (KNOWN, HOVER_POINT)],
    ids=["unknown", "unknown, in a climbing turn", "known"],
)
def test_linear_models_are_those_of_a_description_that_has_it_as_a_link(welded, known, at):
    """A law that knows the payload takes the drag of the body for the same; in hover it is none."""
    study = LinearStudy(Scenario(vehicle=LYING))
    values = {**study.gains, **CARRIED, **known}
    sampled, continuous = study.sampled(at, values), study.continuous(at, values)

    whole, bare = read_description(welded), read_description(UNEVEN)
    law_knows = whole if known else bare
    base = replace(study.setup, description=law_knows, vehicle=make_vehicle(law_knows))
    setup = Laden(**{each.name: getattr(base, each.name) for each in fields(base)}, laden=whole)
    derivatives, rates = Derivatives(setup), setup.rates
    _, rate = sampled_estimate(rates.control_period)
    trim = find_trim(derivatives, make_vehicle(whole), study.gains, at, rate)
    delays = setup.variation.delays(rates.physics_step, rates.control_period)
    core = FlightDerivatives(make_flight_core(setup), setup.controller, setup.vehicle)
    for found, wanted in (
        (sampled, sampled_model(derivatives, trim, rates, rate, delays).lean(REMOVABLE)),
        (continuous, core.model(trim, dict(study.gains))),
    ):
        assert found.trim.state == pytest.approx(wanted.trim.state, abs=1e-9)
        for name in ("A", "input_matrix", "output_matrix", "feedthrough"):
            theirs = getattr(wanted, name)
            size = np.abs(theirs).max()
            assert getattr(found, name) == pytest.approx(theirs, rel=1e-9, abs=1e-9 * size), name

    without = study.sampled(at)
    again = study.sampled(at, {**values, "payload_mass": 0.0, "known_payload_mass": 0.0})
    assert again.A.tobytes() == without.A.tobytes()
    assert np.abs(sampled.A - without.A).max() > 1e-3


def test_contact_carries_it_too(welded):
    """Fallen and at rest: as a drone that has it as a link. Dropped: as one that never had it."""
    start = ScenarioStart(mode="off", position=[0.0, 0.0, 0.2], roll_pitch_yaw=[0.2, -0.1, 0.3])
    whole = Session(Scenario(vehicle=VehicleConfig(str(welded)), start=start))
    session = Session(Scenario(vehicle=LYING, start=start), CARRIED)
    empty = Session(Scenario(vehicle=LYING, start=start))
    area = {"drag_area": empty.get("drag_area")}
    for each in (whole, session, empty):
        each.do(Action(set=area))
        each.tick(0.5)
    assert state(session) == pytest.approx(state(whole), abs=1e-6)
    assert np.abs(state(session) - state(empty)).max() > 1e-3
    for mass in (0.1, 0.0):
        session.set("payload_mass", mass)
        empty.begin_from(session.instant())
        for each in (whole, session, empty):
            each.tick(0.5)
        # on the ground CENIC keeps the size of its last step outside the Context
        assert state(session) == pytest.approx(state(empty), abs=1e-6)
    assert state(session)[6] > state(whole)[6] + 1e-6


def test_without_mass_a_payload_is_none_to_the_bit():
    placed = {name: value for name, value in CARRIED.items() if name != "payload_mass"}
    sessions = Session(), Session(settings=placed), Session(settings={**CARRIED, **KNOWN})
    for session in sessions:
        session.set("payload_mass", 0.0)
        session.set("known_payload_mass", 0.0)
        session.command([1.0, 0.5, -0.2], 0.2)
        session.tick(1.0)
    plain, *others = (state(session).tobytes() for session in sessions)
    assert others == [plain, plain]


def test_the_state_goes_on_when_it_changes():
    session = Session()
    session.command([3.0, 0.0, 1.0], 0.4)
    session.tick(1.0)
    before = state(session)
    session.do(Action(set={**CARRIED, **KNOWN}))
    assert state(session).tobytes() == before.tobytes()
    session.tick(1 / 128)
    assert np.abs(state(session) - before).max() < 0.04


def test_a_flight_goes_on_from_an_instant_with_its_payload():
    """In the air to the bit, on the ground to a micrometre: see `test_checkpoint`."""
    script = [
        Action(at=0.2, set={**CARRIED, "known_payload_mass": 0.1}),
        Action(at=0.5, request="land"),
    ]
    scenario = Scenario(duration=6.0, start=ScenarioStart(position=[0.0, 0.0, 0.6]), script=script)
    flown, other = Session(scenario), Session(scenario)
    for time in (0.4, 4.0):
        flown.tick(time - flown.time)
        other.begin_from(flown.instant())
        flown.tick(0.5)
        other.tick(0.5)
        assert other.get("payload_mass") == MASS
        assert other.state() == pytest.approx(flown.state(), abs=1e-6 * (time > 1.0))


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"payload_mass": -0.1}, "payload_mass is -0.1 kg: keep it within 0 .. 100 kg"),
        ({"payload_mass": float("nan")}, "payload_mass is 'nan': give it a number"),
        ({"known_payload_mass": float("inf")}, "known_payload_mass is inf kg: keep it within"),
        ({"payload_size_y": -1.0}, "payload_size_y is -1 m: keep it within 0 .. 10 m"),
        (
            {"payload_x": 5.0, "known_payload_mass": 5.0},
            "the law cannot fly with a known payload of 5 kg at (5, 0, 0) m",
        ),
    ],
    ids=str,
)
def test_nonsense_is_refused_and_nothing_of_it_is_set(values, said):
    session = Session()
    engine = RolloutEngine(session.vehicle, threads=1)
    acts = (
        lambda: Session(settings=values),
        lambda: Session(Scenario(script=[Action(at=1.0, set=values)])),
        lambda: session.do(Action(set={"payload_size_z": 0.1, **values})),
        lambda: engine.fly([{}, values], "x", 1.0, duration=0.1),
        lambda: LinearStudy().sampled(gains=values),
    )
    for act in acts:
        with pytest.raises(WorkbenchError) as caught:
            act()
        assert said in str(caught.value)
    assert {name: session.get(name) for name in NO_PAYLOAD._fields} == NO_PAYLOAD._asdict()


def test_what_a_script_sets_at_once_is_looked_at_as_a_whole():
    """Mass first would be refused at the old place, and the place first with the old mass."""
    session = Session(settings={"payload_x": 5.0})
    session.do(Action(set={"known_payload_mass": 0.5, "payload_x": 0.0}))
    session.do(Action(set={"payload_x": 5.0, "known_payload_mass": 0.0}))
    assert (session.get("payload_x"), session.get("known_payload_mass")) == (5.0, 0.0)


def test_a_study_that_was_refused_a_payload_goes_on_without_it():
    study = LinearStudy()
    wanted = study.sampled().A
    far = {"payload_x": 5.0, "known_payload_mass": 5.0}
    for _ in range(2):
        with pytest.raises(WorkbenchError, match="the law cannot fly with a known payload"):
            study.sampled(gains=far)
    assert study.sampled().A.tobytes() == wanted.tobytes()
