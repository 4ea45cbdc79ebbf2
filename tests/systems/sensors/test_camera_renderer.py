"""What a depth camera sees of a scene, against closed forms written here."""

import logging

import numpy as np
import pytest
from pydrake.geometry import Box, HalfSpace, Mesh, SceneGraph, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.plant.sensors import DepthCamera
from workbench.systems.sensors.depth_camera import add_depth_camera
from workbench.systems.sensors.readings import DepthImage

WIDTH, HEIGHT, FOV = 160, 120, 1.2
NEAR, FAR = 0.1, 10.0
GREY, RED, GREEN = ([0.5, 0.5, 0.5, 1.0], [0.9, 0.1, 0.1, 1.0], [0.1, 0.9, 0.1, 1.0])
INERTIA = SpatialInertia(1.0, np.zeros(3), UnitInertia(0.1, 0.1, 0.1))
BOX = np.array([0.8, 1.2, 1.6])
X_WBOX = RigidTransform(RollPitchYaw(0.4, -0.3, 0.9), [4.0, 0.3, 1.2])
LOW = RigidTransform([0.0, 0.0, 1.5])
"""A camera that looks level, 1.5 m above the ground."""


class Scene:
    """A plant with one free body, on which cameras are mounted."""

    def __init__(self, ground=True):
        self.builder = DiagramBuilder()
        self.plant: MultibodyPlant
        self.scene_graph: SceneGraph
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(self.builder, 1 / 1024)
        self.plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        self.body: RigidBody = self.plant.AddRigidBody("base", INERTIA)
        if ground:
            self.draw(RigidTransform(), HalfSpace(), GREY)

    def draw(self, X_BG, shape, colour=GREY, body=None):
        body = body or self.plant.world_body()
        name = f"shape{self.scene_graph.model_inspector().num_geometries()}"
        self.plant.RegisterVisualGeometry(body, X_BG, shape, name, np.array(colour))

    def look(self, X_WB=LOW, X_BS=None, far=FAR, count=1) -> DepthImage:
        """Return what the last of `count` cameras sees from there."""
        X_BS = X_BS or RigidTransform()
        sensor = DepthCamera(
            name="camera",
            type="rgbd_camera",
            frame="camera_link",
            link="base",
            rate=16.0,
            p_BS=tuple(X_BS.translation()),
            R_BS=tuple(map(tuple, X_BS.rotation().matrix())),
            width=WIDTH,
            height=HEIGHT,
            horizontal_fov=FOV,
            near=NEAR,
            far=far,
        )
        self.plant.Finalize()
        for n in range(count):
            camera = add_depth_camera(
                self.builder,
                self.plant,
                self.scene_graph,
                self.body,
                sensor,
                name=f"camera{n}",
                period=1 / 16,
            )
        simulator = Simulator(self.builder.Build())
        root = simulator.get_mutable_context()
        context = self.plant.GetMyMutableContextFromRoot(root)
        self.plant.SetFreeBodyPose(context, self.body, X_WB)
        simulator.AdvancePendingEvents()
        image = camera.reading(camera.GetMyContextFromRoot(root))
        assert image is not None
        return image


def directions_W(X_WS):
    """Return the direction of each pixel's centre, 1 m along the optical axis (rows, columns, 3).

    Of the picture's width, which covers the angle of view, column u has the share from u to u + 1.
    """
    half = np.tan(FOV / 2.0)
    left = half * (1.0 - 2.0 * (np.arange(WIDTH) + 0.5) / WIDTH)
    up = half * HEIGHT / WIDTH * (1.0 - 2.0 * (np.arange(HEIGHT) + 0.5) / HEIGHT)
    left, up = np.meshgrid(left, up)
    return np.stack([np.ones_like(left), left, up], axis=-1) @ X_WS.rotation().matrix().T


def ground_depth(X_WS):
    with np.errstate(divide="ignore"):
        depth = -X_WS.translation()[2] / directions_W(X_WS)[..., 2]
    return np.where(depth > 0.0, depth, np.inf)


def box_depth(X_WS, X_WG, size):
    """Return the depth of the box, and the number of the face that is seen, -1 beside it."""
    X_GS = X_WG.inverse() @ X_WS
    along = directions_W(X_WS) @ X_WG.rotation().matrix()
    ends = np.array([-1.0, 1.0])[:, None, None, None] * np.asarray(size) / 2.0
    crossings = (ends - X_GS.translation()) / along
    enters, leaves = crossings.min(axis=0), crossings.max(axis=0)
    hit = enters.max(axis=-1) < leaves.min(axis=-1)
    depth = np.where(hit & (enters.max(axis=-1) > 0.0), enters.max(axis=-1), np.inf)
    return depth, np.where(np.isfinite(depth), enters.argmax(axis=-1), -1)


def inside(surface):
    """Return where all eight neighbours show the same surface."""
    middle = surface[1:-1, 1:-1]
    same = np.zeros(surface.shape, dtype=bool)
    same[1:-1, 1:-1] = True
    for row in range(3):
        for column in range(3):
            shifted = surface[row : HEIGHT - 2 + row, column : WIDTH - 2 + column]
            same[1:-1, 1:-1] &= shifted == middle
    return same


def error(image, exact, compared):
    """Return the largest error of depth among the compared pixels [m]."""
    return np.abs(image.depth[compared] - exact[compared]).max()


def random_pose(seed, height=2.0, tilt=0.6):
    rng = np.random.default_rng(seed)
    roll, pitch, yaw = rng.uniform(-1.0, 1.0, 3) * [tilt, tilt, np.pi]
    return RigidTransform(RollPitchYaw(roll, pitch, yaw), [*rng.uniform(-3.0, 3.0, 2), height])


def poses_at_the_box():
    """Return camera poses around the box that look at it."""
    poses = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        away = rng.normal(size=3)
        away[2] = abs(away[2])
        p_WS = X_WBOX.translation() + rng.uniform(2.5, 8.0) * away / np.linalg.norm(away)
        forward = X_WBOX.translation() + rng.uniform(-0.4, 0.4, 3) - p_WS
        R_WS = RotationMatrix.MakeFromOneVector(forward, axis_index=0)
        poses.append(RigidTransform(R_WS, p_WS))
    return poses


@pytest.mark.parametrize("seed", range(4))
def test_the_ground_is_where_it_is_to_a_millimetre(seed):
    X_WB = random_pose(seed)
    image = Scene().look(X_WB)
    exact = ground_depth(X_WB)
    near_limit = abs(exact - FAR) < 1e-3
    np.testing.assert_array_equal(np.isfinite(image.depth) | near_limit, (exact < FAR) | near_limit)
    seen = np.isfinite(image.depth)
    assert seen.sum() > 500
    assert error(image, exact, seen) < 1e-3


@pytest.mark.parametrize("X_WB", poses_at_the_box())
def test_a_box_is_where_it_is_to_a_millimetre(X_WB):
    scene = Scene()
    scene.draw(X_WBOX, Box(*BOX), RED)
    image = scene.look(X_WB)
    box, face = box_depth(X_WB, X_WBOX, BOX)
    ground = ground_depth(X_WB)
    exact = np.minimum(box, ground)
    compared = inside(np.where(box < ground, face, -1)) & (exact < FAR - 1e-3)
    assert (compared & (box < ground)).sum() > 100
    assert error(image, exact, compared) < 1e-3
    assert (image.depth[inside(exact > FAR + 1e-3) & (exact > FAR + 1e-3)] == np.inf).all()


@pytest.mark.parametrize("seed", range(3))
def test_a_mounting_with_any_rotation_is_right(seed):
    rng = np.random.default_rng(seed)
    X_WS = poses_at_the_box()[seed]
    R_BS = RotationMatrix(RollPitchYaw(*rng.uniform(-3.0, 3.0, 3)))
    X_BS = RigidTransform(R_BS, rng.uniform(-0.5, 0.5, 3))
    scene = Scene(ground=False)
    scene.draw(X_WBOX, Box(*BOX))
    image = scene.look(X_WS @ X_BS.inverse(), X_BS)
    np.testing.assert_allclose(image.p_WS, X_WS.translation(), atol=1e-12)
    np.testing.assert_allclose(image.R_WS, X_WS.rotation().matrix(), atol=1e-12)
    box, face = box_depth(X_WS, X_WBOX, BOX)
    compared = inside(face) & (box < FAR)
    assert error(image, box, compared) < 1e-3


@pytest.mark.parametrize("X_WB", poses_at_the_box()[:3])
def test_the_cloud_lies_on_the_surfaces(X_WB):
    scene = Scene()
    scene.draw(X_WBOX, Box(*BOX))
    image = scene.look(X_WB)
    p_WP = image.points_W()
    from_box = np.abs(X_WBOX.inverse().multiply(p_WP.T)).T - BOX / 2.0
    assert (np.minimum(np.abs(from_box.max(axis=1)), np.abs(p_WP[:, 2])) < 1e-3).all()
    p_SP = image.points_S()
    np.testing.assert_allclose(p_SP[:, 0], image.depth[np.isfinite(image.depth)])
    np.testing.assert_allclose(X_WB.multiply(p_SP.T).T, p_WP, atol=1e-9)


@pytest.mark.parametrize("offset", [(60.0, 0.0), (-400.0, 300.0)])
def test_the_ground_is_seen_far_from_the_origin(offset):
    X_WB = RigidTransform(RollPitchYaw(0.1, 0.4, 0.5), [*offset, 2.0])
    image = Scene().look(X_WB)
    exact = ground_depth(X_WB)
    seen = exact < FAR - 1e-3
    assert error(image, exact, seen) < 1e-3


def test_a_raised_half_space_is_seen_far_from_the_origin():
    scene = Scene(ground=False)
    table = scene.plant.AddRigidBody("table", INERTIA)
    scene.plant.WeldFrames(
        scene.plant.world_frame(), table.body_frame(), RigidTransform([0.0, 0.0, 0.7])
    )
    scene.draw(RigidTransform([0.0, 0.0, 0.3]), HalfSpace(), body=table)
    image = scene.look(RigidTransform(RollPitchYaw(0.0, np.pi / 2.0, 0.0), [80.0, 0.0, 3.0]))
    np.testing.assert_allclose(image.depth, 2.0, atol=1e-3)


@pytest.mark.parametrize(
    ("distance", "seen"),
    [(0.05, -np.inf), (0.099, -np.inf), (0.101, 0.101), (9.99, 9.99), (10.01, np.inf)],
)
def test_out_of_range_is_told_apart(distance, seen):
    scene = Scene(ground=False)
    scene.draw(RigidTransform([distance + 0.5, 0.0, 1.5]), Box(1.0, 100.0, 100.0))
    np.testing.assert_allclose(scene.look().depth, seen, atol=1e-4)


def test_an_empty_world_has_no_returns():
    image = Scene(ground=False).look()
    assert (image.depth == np.inf).all()
    assert image.points_W().shape == (0, 3)


def test_the_picture_is_upright_and_not_mirrored():
    scene = Scene()
    scene.draw(RigidTransform([4.0, 1.0, 2.0]), Sphere(0.4), RED)
    scene.draw(RigidTransform([4.0, -1.0, 2.0]), Sphere(0.4), GREEN)
    colour = scene.look().colour.astype(int)
    red = np.argwhere(colour[..., 0] > 2 * colour[..., 1:].max(axis=-1))
    green = np.argwhere(colour[..., 1] > 2 * colour[..., [0, 2]].max(axis=-1))
    assert min(len(red), len(green)) > 100
    assert red[:, 1].max() < WIDTH / 2 < green[:, 1].min()  # left is left
    assert max(red[:, 0].mean(), green[:, 0].mean()) < HEIGHT / 2  # above the camera is above
    sky, ground = colour[2, WIDTH // 2], colour[-3, WIDTH // 2]
    assert sky[2] > sky[0] + 20
    assert abs(ground - ground.mean()).max() < 3


def test_no_face_in_view_is_black():
    for pitch, yaw in ((-1.5, 0.0), (1.5, 0.0), (0.0, 0.0), (0.0, 1.6), (0.0, 3.1), (0.0, -1.6)):
        scene = Scene(ground=False)
        X_WB = RigidTransform(RollPitchYaw(0.0, pitch, yaw), [0.0, 0.0, 0.0])
        scene.draw(X_WB @ RigidTransform([3.0, 0.0, 0.0]), Box(1.0, 20.0, 20.0))
        assert scene.look(X_WB).colour.min() > 25


def test_the_vehicle_itself_is_not_seen():
    bare, housed = Scene(), Scene()
    part = housed.plant.AddRigidBody("part", INERTIA)
    housed.plant.WeldFrames(housed.body.body_frame(), part.body_frame())
    housed.draw(RigidTransform(), Box(1.0, 1.0, 1.0), body=housed.body)
    housed.draw(RigidTransform([1.0, 0.0, 0.0]), Sphere(0.2), body=part)
    X_WB = random_pose(3)
    one, other = bare.look(X_WB), housed.look(X_WB)
    np.testing.assert_array_equal(one.depth, other.depth)
    np.testing.assert_array_equal(one.colour, other.colour)


def test_several_cameras_share_a_renderer():
    one, two = Scene(), Scene()
    X_WB = random_pose(1)
    np.testing.assert_array_equal(one.look(X_WB).depth, two.look(X_WB, count=2).depth)


def test_a_long_range_is_no_reason_to_warn(caplog):
    with caplog.at_level(logging.WARNING):
        image = Scene().look(random_pose(2, tilt=0.0), far=300.0)
    assert not caplog.records
    exact = ground_depth(random_pose(2, tilt=0.0))
    seen = exact < 290.0
    assert (np.abs(image.depth[seen] / exact[seen] - 1.0)).max() < 1e-4


def test_a_mesh_that_the_renderer_does_not_take_is_named(tmp_path):
    bare = tmp_path / "bare.obj"
    bare.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = Scene()
    scene.draw(RigidTransform([3.0, 0.0, 1.0]), Mesh(str(bare)))
    with pytest.raises(WorkbenchError, match="(?s)camera cannot draw a mesh: .*normals") as caught:
        scene.look()
    said = str(caught.value)
    assert "bare.obj" in said
    assert "\n" not in said
    assert said.endswith("or take it out")
