"""A quadrotor of records whose plugins stand in a file of their own, a tag a line."""

from collections.abc import Callable

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.formats.xml import read_xml
from workbench.plant.model import Inertial, Joint, Link, Model

ARMS = ((0.2, 0.0), (0.0, 0.2), (-0.2, 0.0), (0.0, -0.2))


def pose(xyz, rpy=(0.0, 0.0, 0.0)) -> RigidTransform:
    return RigidTransform(RollPitchYaw(rpy), xyz)


def make_link(name, X_ML=None, mass=None, com=(0.0, 0.0, 0.0)) -> Link:
    inertial = None
    if mass is not None:
        inertial = Inertial(mass, RigidTransform(list(com)), (0.01, 0.012, 0.02), (0.0, 0.0, 0.0))
    return Link(name, X_ML or RigidTransform(), inertial, (), ())


@pytest.fixture
def link() -> Callable[..., Link]:
    return make_link


@pytest.fixture
def joint() -> Callable[..., Joint]:
    """A joint at its child, which turns about z unless it is said otherwise."""

    def make(name, child: Link, axis=(0.0, 0.0, 1.0), kind="continuous", X_MJ=None) -> Joint:
        return Joint(name, kind, "base", child.name, X_MJ or child.X_ML, axis)

    return make


@pytest.fixture
def model(tmp_path, joint) -> Callable[..., Model]:
    """A plus-shaped quadrotor of 1.2 kg, 3 m up in the model frame, turned a quarter to the left.

    In its body frame the rotors are at +x, +y, -x, -y.
    """

    def make(plugins="", links=None, joints=None, properties=(), name="quad") -> Model:
        path = tmp_path / "quad.sdf"
        path.write_text(f"<model>\n{plugins}\n</model>")
        X_MB = pose((0.0, 0.0, 3.0), (0.0, 0.0, 1.5707963267948966))
        rotors = [
            make_link(f"rotor_{i}", X_MB @ pose((x, y, 0.05))) for i, (x, y) in enumerate(ARMS)
        ]
        return Model(
            source=path,
            name=name,
            links=(make_link("base", X_MB, mass=1.2), *(rotors if links is None else links)),
            joints=tuple(
                [joint(f"joint_{i}", rotor) for i, rotor in enumerate(rotors)]
                if joints is None
                else joints
            ),
            frames=(),
            sensors=(),
            plugins=tuple(read_xml(path)),
            properties=properties,
        )

    return make
