"""Free bodies that `<weld>` or `<connect>` holds, against MuJoCo's mass matrix of one tree."""

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant

mujoco = pytest.importorskip("mujoco")

PLACES = ((0.1, 0.1), (0.1, -0.1), (-0.1, 0.1), (-0.1, -0.1))
SITES = "".join(f'<site name="s{i}" pos="{x} {y} 0"/>' for i, (x, y) in enumerate(PLACES))
MOTORS = "".join(
    f'<motor site="s{i}" ctrlrange="0 8" gear="0 0 1 0 0 {0.02 if x * y > 0 else -0.02}"/>'
    for i, (x, y) in enumerate(PLACES)
)
BOX = '<geom type="box" size=".03 .02 .01" pos=".01 0 0" mass=".3"/>'
FREE = f'<body name="crate" pos=".1 2.2 2.9"><freejoint/>{BOX}</body>'
MODEL = """<mujoco><worldbody>
  <body name="hull" pos="0 2 3"><freejoint/><geom type="box" size=".1 .1 .03" mass="1"/>{sites}
    <body name="foot" pos="0 0 -.05" quat=".8 0 .6 0"><geom size=".02" mass=".1"/>{inside}</body>
    {below}</body>
  {free}</worldbody>
  <equality>{equality}</equality><actuator>{motors}</actuator></mujoco>"""


def write(tmp_path, equality="", free="", below="", inside=""):
    """Write a drone with its crate somewhere, and return its path."""
    path = tmp_path / "loaded.xml"
    path.write_text(
        MODEL.format(
            sites=SITES, motors=MOTORS, equality=equality, free=free, below=below, inside=inside
        )
    )
    return path


def masses(path) -> tuple[np.ndarray, np.ndarray]:
    """Return the mass matrices of MuJoCo, and of our plant in MuJoCo's order."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full, our_masses(path)


def our_masses(path) -> np.ndarray:
    plant, _ = add_plant(DiagramBuilder(), read_description(path), time_step=0.0)
    mass = plant.CalcMassMatrix(plant.CreateDefaultContext())
    order = [3, 4, 5, 0, 1, 2, *range(6, len(mass))]  # translations first
    return mass[np.ix_(order, order)]


RELPOSE = ".05 .02 -.2 .6 0 0 .8"
CASES = (
    # equality, and the same load in the tree: below the hull, or inside the foot
    ('<weld body1="hull" body2="crate"/>', f'<body pos=".1 .2 -.1">{BOX}</body>', ""),
    (
        f'<weld body1="hull" body2="crate" relpose="{RELPOSE}"/>',
        f'<body pos=".05 .02 -.2" quat=".6 0 0 .8">{BOX}</body>',
        "",
    ),
    (
        f'<weld body1="foot" body2="crate" relpose="{RELPOSE}"/>',
        "",
        f'<body pos=".05 .02 -.2" quat=".6 0 0 .8">{BOX}</body>',
    ),
    (  # by its own corner: 0.6 0 0 0.8 turns x to -0.28 0.96 0
        f'<weld body1="hull" body2="crate" relpose="{RELPOSE}" anchor=".1 0 0"/>',
        f'<body pos=".078 -.076 -.2" quat=".6 0 0 .8">{BOX}</body>',
        "",
    ),
    (  # the hull as the crate sees it: the inverse of a quarter turn
        '<weld body1="crate" body2="hull" relpose="0 0 .2 .6 0 0 .8"/>',
        f'<body pos="0 0 -.2" quat=".6 0 0 -.8">{BOX}</body>',
        "",
    ),
    (
        '<connect body1="hull" body2="crate" anchor=".1 .2 -.05"/>',
        f'<body pos=".1 .2 -.1"><joint type="ball" pos="0 0 .05"/>{BOX}</body>',
        "",
    ),
    (
        '<connect body1="crate" body2="hull" anchor="0 .01 .05"/>',
        f'<body pos=".1 .2 -.1"><joint type="ball" pos="0 .01 .05"/>{BOX}</body>',
        "",
    ),
)


def test_a_load_that_is_held_is_the_same_as_in_the_tree(tmp_path, case):
    for equality, below, inside in CASES:
        with case(equality):
            expected, same = masses(write(tmp_path, below=below, inside=inside))
            assert same == pytest.approx(expected, abs=1e-9)
            path = write(tmp_path, equality, free=FREE)
            assert our_masses(path) == pytest.approx(expected, abs=1e-9)
            said = {each.element: each.text for each in read_description(path).remarks}
            assert "holds it to" in said["body 'crate'"]
            assert not {"element <weld>", "element <connect>"} & said.keys()


def test_a_load_that_nothing_holds_is_refused(tmp_path, case):
    weld = '<weld body1="{}" body2="crate" active="{}"/>'
    for equality in ("", weld.format("hull", "false"), '<weld body1="crate"/>'):
        with (
            case(equality),
            pytest.raises(WorkbenchError, match="by a <weld> or <connect> of body1"),
        ):
            read_description(write(tmp_path, equality, free=FREE))


def test_a_second_weld_of_a_load_closes_no_loop(tmp_path):
    """Both ends fly as one body, so it holds what is held; two connections are a loop."""
    second = '<weld name="again" body1="foot" body2="crate"/>'
    weld, connect = CASES[0][0], CASES[5][0]
    path = write(tmp_path, weld + second, free=FREE)
    assert len(our_masses(path)) == 6
    third = '<connect body1="foot" body2="crate" anchor="0 0 0"/>'
    with pytest.raises(WorkbenchError, match="<connect> between crate, foot closes a loop"):
        read_description(write(tmp_path, connect + third, free=FREE))
    hinge = connect + '<connect body1="crate" body2="hull" anchor=".1 0 0"/>'
    with pytest.raises(WorkbenchError, match="crate, hull makes a hinge of another one: give the"):
        read_description(write(tmp_path, hinge, free=FREE))


def test_a_relpose_of_six_numbers_is_refused(tmp_path):
    weld = '<weld body1="hull" body2="crate" relpose="0 0 1 1 0 0"/>'
    with pytest.raises(WorkbenchError, match="<weld relpose>: give it seven numbers"):
        read_description(write(tmp_path, weld, free=FREE))


def test_a_hold_with_the_name_of_a_joint_takes_no_joint_away(tmp_path, case):
    """Names of MuJoCo differ within a kind, and an equality is no joint."""
    arm = '<body name="arm"><joint name="{}" axis="0 1 0"/><geom size=".02" mass=".1"/></body>'
    for equality, hinge, freedoms in (
        ('<weld name="j1" body1="hull" body2="crate"/>', "j1", 7),
        ('<connect name="j1" body1="hull" body2="crate" anchor="0 0 0"/>', "j1", 10),
        ('<weld body1="hull" body2="crate"/>', "crate_hold", 7),
    ):
        path = write(tmp_path, equality, FREE, below=arm.format(hinge))
        with case(equality):
            assert len(our_masses(path)) == freedoms


def test_a_joint_with_the_usual_name_of_another_one_takes_none_away(tmp_path):
    """Bodies without a joint and loads on tendons have joints of names of their own."""
    arm = '<body name="arm"><joint name="{}" axis="0 1 0"/><geom size=".02" mass=".1"/></body>'
    expected, same = masses(write(tmp_path, below=arm.format("foot_weld")))
    assert same == pytest.approx(expected, abs=1e-9)
    assert len(same) == 7
    free = FREE.replace("<freejoint/>", '<freejoint/><site name="e"/>')
    path = write(tmp_path, free=free, below=arm.format("crate_joint"))
    cable = '<tendon><spatial range="0 1"><site site="s0"/><site site="e"/></spatial></tendon>'
    path.write_text(path.read_text().replace("<equality>", f"{cable}<equality>"))
    assert len(our_masses(path)) == 13


def test_two_joints_of_one_name_are_refused(tmp_path):
    arm = '<body><joint name="j" axis="0 1 0"/><geom size=".02" mass=".1"/></body>'
    with pytest.raises(WorkbenchError, match="there are two joints named 'j': rename one"):
        read_description(write(tmp_path, below=arm + arm))


def test_a_hold_that_does_not_act_from_the_beginning_holds_nothing(tmp_path):
    weld = '<weld body1="hull" body2="crate"{}/>'
    default = '<default><equality active="false"/></default><worldbody>'
    path = write(tmp_path, weld.format(' active="true"'), FREE)
    path.write_text(path.read_text().replace("<worldbody>", default))
    assert len(our_masses(path)) == 6
    path.write_text(path.read_text().replace(' active="true"', ""))
    assert not mujoco.MjModel.from_xml_path(str(path)).eq_active0[0]
    with pytest.raises(WorkbenchError, match="by a <weld> or <connect> of body1"):
        read_description(path)


def test_what_a_hold_says_and_is_not_read_is_refused(tmp_path, case):
    for words, said in (
        ('torquescale="0"', "torquescale>: 0 leaves the attitude free: write a <connect>"),
        ('site1="s0"', "<weld site1>: not read here: leave it out"),
    ):
        path = write(tmp_path, f'<weld body1="hull" body2="crate" {words}/>', FREE)
        with case(words), pytest.raises(WorkbenchError, match=said):
            read_description(path)


def test_a_weld_comes_before_a_connection_of_the_same_two(tmp_path):
    weld, connect = CASES[0][0], CASES[5][0]
    assert len(our_masses(write(tmp_path, connect + weld, FREE))) == 6
