"""Oracle: Drake's own sums over the links as bodies, welded as the description hangs them."""

import dataclasses
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import DiagramBuilder

from tests.installed import readable
from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import write_urdf
from workbench.plant.gathered import link_of, merged_model
from workbench.plant.loading import make_vehicle
from workbench.plant.model import Inertial, Link, LinkShape, Model
from workbench.plant.multibody import add_plant
from workbench.plant.shapes import Sphere

DRONES = Path(__file__).resolve().parents[1] / "drones"
SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "models"
PUBLISHED = {
    "rotors_description/urdf/hummingbird.xacro": {"namespace": "bird"},
    "gym_pybullet_drones/cf2x.urdf": None,
    "px4_gazebo_models/x500": None,
}
FILES = [
    find_model("dh_drone"),
    *sorted(DRONES.glob("*.urdf*")),
    *(SHARED / path for path in readable(PUBLISHED)),
]


@pytest.fixture(params=FILES, ids=lambda path: path.name)
def pair(request):
    """Return a description, and two flying plants of it: as one body, and of a body a link."""
    if not request.param.exists():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    published = request.param.is_relative_to(SHARED)
    args = PUBLISHED[str(request.param.relative_to(SHARED))] if published else None
    description = read_description(request.param, args)
    builder = DiagramBuilder()
    one, _ = add_plant(builder, description, time_step=0.0)
    return description, Placed(builder, one), Placed(*linked(description))


def linked(description):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    text = ET.tostring(write_urdf(description.model), encoding="unicode")
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.mutable_gravity_field().set_gravity_vector(np.array([0.0, 0.0, -9.81]))
    plant.Finalize()
    return builder, plant


class Placed:
    """A plant in a motion like no other."""

    def __init__(self, builder, plant) -> None:
        self.plant = plant
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.context = plant.GetMyMutableContextFromRoot(self.root)
        rng = np.random.default_rng(11)
        q_WB = rng.normal(size=4)
        q_WB /= np.linalg.norm(q_WB)
        state = [*q_WB, 1.0, -2.0, 50.0, *(8.0 * rng.normal(size=3)), *rng.normal(size=3)]
        plant.SetPositionsAndVelocities(self.context, state)
        self.vdot = rng.normal(size=6)
        self.wrench = rng.normal(size=6)

    def inverse_dynamics(self, base_link: str) -> np.ndarray:
        """Return the generalized forces of a motion under gravity and a wrench on the body."""
        forces = MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self.context, forces)
        self.plant.GetBodyByName(base_link).AddInForceInWorld(
            self.context, SpatialForce(self.wrench), forces
        )
        return self.plant.CalcInverseDynamics(self.context, self.vdot, forces)

    def shapes(self, name_of) -> dict[tuple[str, str], RigidTransform]:
        """Return X_WG of all shapes of the drone, by role and name."""
        scene_graph = self.diagram.GetSubsystemByName("scene_graph")
        context = scene_graph.GetMyContextFromRoot(self.root)
        query = scene_graph.get_query_output_port().Eval(context)
        inspector = query.inspector()
        return {
            (str(role), name_of(inspector, geometry)): query.GetPoseInWorld(geometry)
            for role in (Role.kProximity, Role.kIllustration, Role.kPerception)
            for geometry in inspector.GetAllGeometryIds(role)
            if inspector.GetFrameId(geometry) != inspector.world_frame_id()
        }


def assert_same(found, wanted):
    """Equal to 1e-12 of the largest number: small ones are what is left of large ones."""
    assert found == pytest.approx(wanted, rel=0.0, abs=1e-12 * np.abs(wanted).max())


def test_it_moves_as_its_links_do(pair):
    description, one, links = pair
    assert one.plant.num_multibody_states() == links.plant.num_multibody_states() == 13
    for calculate in ("CalcMassMatrix", "CalcBiasTerm", "CalcGravityGeneralizedForces"):
        found, wanted = (getattr(each.plant, calculate)(each.context) for each in (one, links))
        assert_same(found, wanted)
    base = description.base_link
    assert_same(one.inverse_dynamics(base), links.inverse_dynamics(base))


def test_it_is_one_body_with_the_links_as_frames(pair):
    description, one, links = pair
    drone = one.plant.GetBodyByName(description.base_link).model_instance()
    assert len(one.plant.GetBodyIndices(drone)) == 1
    for link in description.model.links:
        X_WL = links.plant.EvalBodyPoseInWorld(links.context, links.plant.GetBodyByName(link.name))
        frame = one.plant.GetFrameByName(link.name, drone)
        assert frame.CalcPoseInWorld(one.context).IsNearlyEqualTo(X_WL, 1e-12)


def test_the_vehicle_weighs_what_drake_sums(pair):
    description, _, links = pair
    vehicle = make_vehicle(description)
    base = links.plant.GetBodyByName(description.base_link)
    bodies = links.plant.GetBodyIndices(base.model_instance())
    at_rest = links.plant.CreateDefaultContext()  # at the origin, where rounding is smallest
    whole = links.plant.CalcSpatialInertia(at_rest, base.body_frame(), bodies)
    assert vehicle.mass == pytest.approx(whole.get_mass(), rel=1e-14)
    assert vehicle.p_BoBcm_B == pytest.approx(whole.get_com(), abs=1e-14)
    inertia = whole.Shift(whole.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    assert_same(vehicle.inertia, inertia)
    for frame in vehicle.frames:
        body = links.plant.GetBodyByName(frame.name)
        X_BL = body.body_frame().CalcPose(at_rest, base.body_frame())
        assert frame.p_BF == pytest.approx(X_BL.translation(), abs=1e-14)
        assert np.array(frame.R_BF) == pytest.approx(X_BL.rotation().matrix(), abs=1e-14)
    assert [frame.name for frame in vehicle.frames] == [
        link.name for link in description.model.links
    ]


def test_every_shape_is_where_its_link_has_it(pair):
    description, one, links = pair

    def of_link(inspector, geometry):
        body = links.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        shape = inspector.GetName(geometry).removeprefix(f"{description.name}::")
        return f"{body.name()}::{shape}"

    def of_one(inspector, geometry):
        return inspector.GetName(geometry).removeprefix(f"{description.name}::")

    found, wanted = one.shapes(of_one), links.shapes(of_link)
    # spheres at the corners of a shape, by which it touches the ground
    found = {key: X_WG for key, X_WG in found.items() if not key[1].startswith("corner_")}
    wanted = {key: X_WG for key, X_WG in wanted.items() if "::corner_" not in key[1]}
    assert set(found) == set(wanted)
    for key, X_WG in wanted.items():
        assert found[key].IsNearlyEqualTo(X_WG, 1e-12), key


def a_link(name: str, X_ML: RigidTransform, *shapes: str, inertial=None) -> Link:
    collisions = (LinkShape(shape, RigidTransform([0, 0, 1.0]), Sphere(0.1)) for shape in shapes)
    return Link(name, X_ML, inertial, (), tuple(collisions))


def a_model(*links: Link) -> Model:
    return Model(Path("any.urdf"), "any", links, (), (), (), ())


def test_two_masses_far_from_the_base():
    """1 kg at (1, 0, 0) and 3 kg at (0, 0, 4), in a base that is turned and moved itself.

    Their centre is at (0.25, 0, 3). Points at distances d from it add m (d.d - d_i d_i).
    """
    X_MB = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [5.0, 6.0, 7.0])
    point = Inertial(1.0, RigidTransform([1.0, 0.0, 0.0]), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    ball = Inertial(3.0, RigidTransform([2.0, 0.0, 0.0]), (0.5, 0.5, 0.5), (0.0, 0.0, 0.0))
    turn = RollPitchYaw(0.0, -np.pi / 2.0, 0.0)  # x of the link is z of the base
    mast = a_link("mast", X_MB @ RigidTransform(turn, [0.0, 0.0, 2.0]), inertial=ball)
    model = merged_model(a_model(a_link("base", X_MB, inertial=point), mast), "base")
    (body,) = model.links
    assert body.inertial.mass == 4.0
    assert body.inertial.X_LI.translation() == pytest.approx([0.25, 0.0, 3.0])
    first, second = np.array([0.75, 0.0, -3.0]), np.array([-0.25, 0.0, 1.0])
    wanted = 0.5 * np.eye(3)
    for mass, d in ((1.0, first), (3.0, second)):
        wanted += mass * (d @ d * np.eye(3) - np.outer(d, d))
    assert body.inertial.moments == pytest.approx(tuple(np.diag(wanted)))
    assert body.inertial.products == pytest.approx((0.0, wanted[0, 2], 0.0), abs=1e-12)
    (frame,) = model.frames
    assert (frame.name, frame.link) == ("mast", "base")
    assert frame.X_LF.IsNearlyEqualTo(RigidTransform(turn, [0.0, 0.0, 2.0]), 1e-12)


def test_a_lone_inertia_stays_as_it_is():
    """The base's own, to the bit, where no other link has one."""
    X_LI = RigidTransform(RollPitchYaw(0.3, 0.2, 0.1), [0.1, 0.2, 0.3])
    own = Inertial(1.0, X_LI, (0.1, 0.2, 0.25), (0.01, 0.02, 0.03))
    base, bare = RigidTransform(), a_link("bare", RigidTransform([0.0, 0.0, 1.0]))
    (body,) = merged_model(a_model(a_link("base", base, inertial=own), bare), "base").links
    assert dataclasses.replace(body.inertial, X_LI=X_LI) == own
    assert body.inertial.X_LI.IsExactlyEqualTo(X_LI)


def test_a_lone_inertia_on_another_link_is_where_that_is():
    X_BL, X_LI = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0, 0, 1.0]), RigidTransform([1, 0, 0])
    own = Inertial(1.0, X_LI, (0.1, 0.2, 0.25), (0.0, 0.0, 0.0))
    links = a_link("base", RigidTransform()), a_link("box", X_BL, inertial=own)
    (body,) = merged_model(a_model(*links), "base").links
    assert body.inertial.X_LI.IsNearlyEqualTo(X_BL @ X_LI, 1e-12)


def test_without_any_mass_there_is_no_inertia():
    (body,) = merged_model(a_model(a_link("base", RigidTransform())), "base").links
    assert body.inertial is None


@pytest.mark.parametrize("link", ["base", "arm", "nested::arm", "nested::arm::tip"])
@pytest.mark.parametrize("drone", ["any", "a::b"])
def test_a_shape_tells_the_link_it_comes_from(link, drone):
    names = {"base", link}
    links = [a_link(name, RigidTransform(), "ball", "ball", "a::b") for name in sorted(names)]
    (body,) = merged_model(a_model(*links), "base").links
    assert len(body.collisions) == 3 * len(names)
    found = {link_of(f"{drone}::{collision.name}", drone) for collision in body.collisions}
    assert found == names
