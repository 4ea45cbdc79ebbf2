"""Mass, inertia, centre of mass and thrusts of MJCF against MuJoCo's own compiler.

The numbers are in `mujoco_numbers.yaml`, by `python tests/extras/formats/test_mjcf_mujoco.py` with
the MuJoCo that they name. Where MuJoCo is installed, it must agree with them.
"""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from workbench.extras.formats.mjcf_words import MJCF_ATTRIBUTES
from workbench.plant.loading import load_vehicle

ENTRIES = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
"""Moments and products of inertia in a matrix."""
NUMBERS = Path(__file__).with_name("mujoco_numbers.yaml")
DOCUMENT = """<mujoco model="wren">
  <compiler {compiler}/>
  {option}
  <default>
    <default class="arm"><geom type="capsule" density="500" group="1"/></default>
    <default class="rotor"><general ctrlrange="0 5"/></default>
    {default}
  </default>
  <asset>{asset}</asset>
  <worldbody>
    {world}
    <body name="hull" pos="1 2 3">
      {free}
      {hull}
      {sites}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>"""
CORNERS = ((0.1, 0.1, -0.02), (-0.1, 0.1, 0.02), (-0.1, -0.1, -0.02), (0.1, -0.1, 0.02))
SITE = '<site name="at_{0}" pos="{1} {2} 0.02"/>'
SITES = "".join(SITE.format(i, x, y) for i, (x, y, _) in enumerate(CORNERS))
PLAIN = {
    "compiler": "",
    "option": "",
    "default": "",
    "asset": "",
    "world": "",
    "free": "<freejoint/>",
    "hull": '<geom type="box" size="0.06 0.05 0.02" mass="0.6"/>',
    "sites": SITES,
    "motors": "",
}


def motors(words: str = "", kind: str = "motor", gear: str = "0 0 1 0 0 {0}") -> str:
    """Return four actuators with more attributes."""
    return "".join(
        f'<{kind} class="rotor" name="m_{i}" site="at_{i}" gear="{gear.format(turn)}" {words}/>'
        for i, (*_, turn) in enumerate(CORNERS)
    )


HULL = PLAIN["hull"]
GEOMS = """
  <geom type="box" size="0.06 0.05 0.02" pos="0.01 0 0.01" euler="10 20 30" {0}/>
  <geom type="sphere" size="0.03" pos="0 0.02 -0.05" {0}/>
  <geom class="arm" size="0.01" fromto="0 0 0 0.1 0.1 0.02" {0}/>
  <geom type="cylinder" size="0.012 0.1" axisangle="1 1 0 40" {0}/>
  <geom type="ellipsoid" size="0.03 0.02 0.01" pos="0.02 0 0" zaxis="0 1 1" {0}/>"""
"""Every shape; a word for all of them."""
TETRAHEDRON = 'vertex="0 0 0 0.2 0 0 0 0.16 0 0.02 0.03 0.12"'
DART = (
    'vertex="0.1 0 0 -0.1 0.1 0 -0.05 0 0 -0.1 -0.1 0 0 0 0.05" '
    'face="0 1 4 1 2 4 2 3 4 3 0 4 0 2 1 0 3 2"'
)
"""A mesh that is not convex."""
ARM = (
    '<body pos="0.15 0 0"><geom type="box" size="0.05 0.01 0.01" mass="0.1"/>'
    '<geom type="sphere" size="0.02" pos="0.05 0.01 0" density="300"/></body>'
)
TILTED = (
    '<replicate count="2" euler="0 0 180"><frame pos="0.1 0.1 0.02">'
    '<site name="at_0" euler="8 0 0"/></frame><frame pos="-0.1 0.1 0.02">'
    '<site name="at_1" euler="0 -8 0"/></frame></replicate>'
)
TWO = "".join(
    f'<motor class="rotor" name="m_{i}" site="at_{i}" gear="0 0 1 0 0 {turn}"/>'
    for i, (*_, turn) in enumerate(CORNERS[:2])
)
CASES: dict[str, dict[str, str]] = {
    "geoms": {"hull": GEOMS.format("")},
    "shells of geoms": {"hull": GEOMS.format('shellinertia="true" density="12"')},
    "shell with a mass": {"hull": GEOMS.format('shellinertia="true" mass="0.1"')},
    "replicate of bodies": {
        "hull": HULL + f'<replicate count="4" euler="0 0 90">{ARM}</replicate>'
    },
    "replicate with offset and turn": {
        "hull": HULL
        + '<replicate count="3" euler="0 10 35" offset="0.03 0.01 0.02" sep="-">'
        + '<geom type="box" size="0.05 0.01 0.01" mass="0.1" pos="0 0.04 0"/></replicate>'
    },
    "replicate in replicate in frame": {
        "hull": HULL
        + '<frame pos="0 0 0.01" euler="0 0 20"><replicate count="2" offset="0 0 0.02">'
        + f'<replicate count="3" euler="0 0 120" sep="_">{ARM}</replicate></replicate></frame>'
    },
    "replicate in fixed axes": {
        "compiler": 'eulerseq="ZYX"',
        "hull": HULL + f'<replicate count="3" euler="40 20 10" offset="0.02 0 0">{ARM}</replicate>',
    },
    "replicate with a class": {
        "default": '<default class="pod"><geom type="box" size="0.02 0.02 0.02" mass="0.07"/>'
        "</default>",
        "hull": HULL + '<replicate count="2" offset="0 0 0.1" childclass="pod"><geom/></replicate>',
    },
    "replicate of sites and their motors": {"sites": TILTED, "motors": TWO},
    "replicate around the drone": {
        "world": '<replicate count="11" offset="1 0 0"><geom type="sphere" size="0.1"/></replicate>'
    },
    "inertiagrouprange": {
        "compiler": 'inertiagrouprange="0 2"',
        "hull": HULL + '<geom type="box" group="3" size="0.1 0.1 0.1" mass="2"/>',
    },
    "inertiagrouprange of the second group": {
        "compiler": 'inertiagrouprange="1 1"',
        "hull": HULL + '<geom class="arm" size="0.05 0.1"/>',
    },
    "inertiagrouprange by class": {
        "compiler": 'inertiagrouprange="0 0"',
        "hull": HULL
        + '<body childclass="arm"><inertial pos="0 0 0.1" mass="0.2" diaginertia="1e-3 1e-3 1e-3"/>'
        '<geom size="0.05 0.1"/></body>',
    },
    "settotalmass": {"compiler": 'settotalmass="1.2"', "hull": HULL + ARM},
    "settotalmass with other bodies": {
        "compiler": 'settotalmass="1.7"',
        "world": '<geom type="sphere" size="1"/><body><geom type="sphere" size="0.05"/></body>',
    },
    "boundmass": {
        "compiler": 'boundmass="0.2"',
        "hull": HULL + '<body pos="0.05 0 0" euler="0 0 30"/>' + ARM,
    },
    "boundinertia": {"compiler": 'boundinertia="0.0009"', "hull": GEOMS.format("") + ARM},
    "boundmass and boundinertia of frames": {
        "compiler": 'boundmass="0.05" boundinertia="0.0002"',
        "hull": HULL + '<body pos="0.05 0.02 0.03"><body pos="0 0 0.04"/></body>',
    },
    "balanceinertia": {
        "compiler": 'balanceinertia="true"',
        "hull": '<inertial pos="0 0 0.01" mass="0.6" diaginertia="0.001 0.001 0.003"/>',
    },
    "balanceinertia with nothing to balance": {
        "compiler": 'balanceinertia="true"',
        "hull": '<inertial pos="0 0 0.01" mass="0.6" diaginertia="0.001 0.002 0.0025"/>',
    },
    "inertiafromgeom true": {
        "compiler": 'inertiafromgeom="true"',
        "hull": HULL + '<inertial pos="0 0 0.01" mass="9" diaginertia="1 1 1"/><body pos="0 0 0.1">'
        '<inertial pos="0.01 0 0" mass="0.1" diaginertia="1e-4 2e-4 2.5e-4"/></body>',
    },
    "inertiafromgeom false": {
        "compiler": 'inertiafromgeom="false"',
        "hull": HULL
        + ARM
        + '<inertial pos="0 0 0.01" quat="1 1 0 0" mass="0.7" diaginertia="1e-3 2e-3 2.5e-3"/>',
    },
    "inertial in a frame": {
        "hull": '<frame pos="0.01 0 0" euler="0 0 90"><inertial pos="0 0.01 0" mass="0.7" '
        'fullinertia="1e-3 2e-3 2.5e-3 1e-4 2e-4 -3e-4"/></frame>'
    },
    "radians": {
        "compiler": 'angle="radian"',
        "hull": '<geom type="box" size="0.06 0.05 0.02" mass="0.6" euler="0.1 0.2 0.3"/>',
    },
    "size of a default in part": {
        "default": '<geom type="box" size="0.06 0.05 0.02"/>',
        "hull": '<geom size="0.04" density="700"/>',
    },
    "orientation in place of that of a default": {
        "default": '<geom type="box" size="0.06 0.05 0.02" euler="0 0 40"/>',
        "hull": '<geom quat="1 0 0 0"/><geom zaxis="0 1 1" mass="0.1"/><geom mass="0.2"/>',
    },
    "mesh by density": {
        "asset": f'<mesh name="m" {TETRAHEDRON} scale="1 1.2 0.7"/>',
        "hull": '<geom type="mesh" mesh="m" pos="-0.06 -0.05 0" euler="0 20 10" density="1500"/>',
    },
    "mesh by mass": {
        "asset": f'<mesh name="m" {DART}/>',
        "hull": HULL + '<geom type="mesh" mesh="m" pos="0.01 0.02 0" mass="0.3"/>',
    },
    "mesh exact, mirrored": {
        "asset": f'<mesh name="m" {DART} inertia="exact" scale="1 -1 1"/>',
        "hull": '<geom type="mesh" mesh="m" density="4000"/>',
    },
    "mesh convex": {
        "asset": f'<mesh name="m" {DART} inertia="convex"/>',
        "hull": '<geom type="mesh" mesh="m" density="2500"/>',
    },
    "mesh shell": {
        "asset": f'<mesh name="m" {DART} inertia="shell"/>',
        "hull": '<geom type="mesh" mesh="m" density="20"/>',
    },
    "mesh with a reference frame": {
        "asset": f'<mesh name="m" {DART} refpos="0.01 0.02 0.03" refquat="1 0 0.3 0" scale="2 2 2"'
        "/>",
        "hull": '<geom type="mesh" mesh="m" density="300"/>',
    },
    "mesh class": {
        "default": '<mesh scale="0.7 0.7 0.7" inertia="shell"/>',
        "asset": f'<mesh name="m" {DART}/>',
        "hull": '<geom type="mesh" mesh="m" density="40"/>',
    },
    "box fitted to a mesh": {
        "asset": f'<mesh name="m" {DART}/>',
        "hull": '<geom type="box" mesh="m" density="2000" fitscale="1.1"/>',
    },
    "capsule fitted to a mesh": {
        "asset": f'<mesh name="m" {DART}/>',
        "hull": '<geom type="capsule" mesh="m" density="2000" euler="0 0 30"/>',
    },
    "no type and a mesh": {
        "asset": f'<mesh name="m" {DART}/>',
        "hull": '<geom mesh="m" density="2000"/>',
    },
    "bounding box of a mesh": {
        "compiler": 'fitaabb="true"',
        "asset": f'<mesh name="m" {DART}/>',
        "hull": '<geom type="cylinder" mesh="m" density="100"/>'
        '<geom type="ellipsoid" mesh="m" mass="0.1"/>',
    },
    "discardvisual": {
        "compiler": 'discardvisual="true"',
        "hull": HULL + '<geom type="sphere" size="0.05" contype="0" conaffinity="0"/>',
    },
    "fluid shapes": {"hull": GEOMS.format('fluidshape="ellipsoid" fluidcoef="1 1 1 1 1"')},
    "joint default armature": {"default": '<joint armature="1"/>'},
    "gain": {"motors": motors('gainprm="3" ctrlrange="0 1"', "general")},
    "bias": {
        "motors": motors(
            'gainprm="3" biastype="affine" biasprm="-1 0 0" ctrlrange="0 2"', "general"
        )
    },
    "bias without biastype": {
        "motors": motors('gainprm="3" biasprm="-1 0 0" ctrlrange="0 2"', "general")
    },
    "negative gain": {
        "motors": motors('gainprm="-3" biastype="affine" biasprm="4.5" ctrlrange="0 2"', "general")
    },
    "forcerange": {"motors": motors('forcerange="-1 3.5"')},
    "actrange": {
        "motors": motors(
            'dyntype="filter" dynprm="0.03" actrange="0 2.5" actlimited="true" gainprm="1.5"',
            "general",
        )
    },
    "gear in part": {
        "default": '<default class="two"><general gear="0 0 2 0 0 -0.03" ctrlrange="0 3"/>'
        '<default class="three"><motor gear="0 0 3 0 0 0.03"/></default></default>',
        "motors": "".join(
            f'<motor name="m_{i}" site="at_{i}" class="{("two", "three")[i % 2]}" gear="0 0"/>'
            for i in range(4)
        ),
    },
    "motor after general default": {
        "default": '<default class="g"><general gainprm="7" ctrlrange="0 3" biastype="affine" '
        'biasprm="2"/></default>',
        "motors": motors().replace('class="rotor"', 'class="g"'),
    },
    "general after motor default": {
        "default": '<default class="g"><general gainprm="7"/><motor ctrlrange="0 3"/></default>',
        "motors": motors(kind="general").replace('class="rotor"', 'class="g"'),
    },
    "site by two points": {
        "sites": "".join(
            f'<site name="at_{i}" type="capsule" size="0.01" '
            f'fromto="{x} {y} 0.1 {1.2 * x} {0.9 * y} 0"/>'
            for i, (x, y, _) in enumerate(CORNERS)
        )
    },
    "site in a turned body and frame": {
        "sites": f'<body pos="0 0 0.1" euler="0 0 90"><frame euler="5 0 0">{SITES}</frame></body>'
    },
    "downward site, reversible": {
        "sites": SITES.replace('0.02"/>', '0.02" euler="180 0 0"/>'),
        "motors": motors('ctrlrange="-5 5"'),
    },
    "downward gear and control": {
        "motors": motors('ctrlrange="-5 0"', gear="0 0 -1 0 0 {0}"),
    },
    "moment across the thrust": {"motors": motors(gear="0 0 1 0.01 -0.02 {0}")},
}


def document(name: str) -> str:
    return DOCUMENT.format(**({**PLAIN, "motors": motors()} | CASES[name]))


def of_mujoco(text: str) -> dict:
    """Return mass, centre, inertia (xx yy zz xy xz yz), and each actuator's wrench at its end."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    root = model.body("hull").id
    bodies = [i for i in range(model.nbody) if model.body_rootid[i] == root]
    masses = model.body_mass[bodies]
    centre = masses @ data.xipos[bodies] / masses.sum()
    inertia = np.zeros((3, 3))
    for body, mass in zip(bodies, masses, strict=True):
        R, r = data.ximat[body].reshape(3, 3), data.xipos[body] - centre
        inertia += R @ np.diag(model.body_inertia[body]) @ R.T
        inertia += mass * (r @ r * np.eye(3) - np.outer(r, r))
    wrenches = []
    for i in range(model.nu):
        best = np.zeros(6)
        for end in model.actuator_ctrlrange[i]:
            data.ctrl[:] = 0.0
            data.ctrl[i] = end
            if model.actuator_actnum[i]:
                data.act[model.actuator_actadr[i]] = np.clip(end, *model.actuator_actrange[i])
            mujoco.mj_forward(model, data)
            arms = np.zeros((model.nu, model.nv))
            mujoco.mju_sparse2dense(
                arms,
                data.actuator_moment,
                data.moment_rownnz,
                data.moment_rowadr,
                data.moment_colind,
            )
            wrench = data.actuator_force[i] * arms[i, :6]
            if wrench[2] > best[2]:
                best = wrench
        wrenches.append(best)
    return {
        "mass": float(masses.sum()),
        "com": (centre - data.xpos[root]).tolist(),
        "inertia": inertia[ENTRIES].tolist(),
        "wrenches": np.array(wrenches).tolist(),
        "names": [model.actuator(i).name for i in range(model.nu)],
    }


def of_workbench(path: Path) -> dict:
    vehicle = load_vehicle(path)
    wrenches = []
    for rotor in vehicle.rotors:
        axis = np.array(rotor.axis_B)
        force = rotor.max_thrust * axis
        moment = np.cross(rotor.p_BR, force) - rotor.direction * rotor.moment_constant * force
        wrenches.append([*force, *moment])
    return {
        "mass": vehicle.mass,
        "com": list(vehicle.p_BoBcm_B),
        "inertia": vehicle.inertia[ENTRIES].tolist(),
        "wrenches": wrenches,
        "names": [rotor.name for rotor in vehicle.rotors],
    }


def agree(ours: dict, theirs: dict) -> None:
    assert ours["names"] == theirs["names"]
    assert ours["mass"] == pytest.approx(theirs["mass"], rel=1e-6)
    assert ours["com"] == pytest.approx(theirs["com"], abs=1e-7)
    scale = max(theirs["inertia"])
    assert ours["inertia"] == pytest.approx(theirs["inertia"], rel=1e-5, abs=1e-5 * scale)
    assert np.array(ours["wrenches"]) == pytest.approx(np.array(theirs["wrenches"]), abs=1e-7)


@pytest.mark.parametrize("name", CASES)
def test_mass_inertia_and_thrusts_are_those_of_mujoco(name, write):
    known = yaml.safe_load(NUMBERS.read_text())["cases"]
    agree(of_workbench(write(document(name), "wren.xml")), known[name])


def test_mujoco_has_the_numbers_of_the_table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # it writes its warnings to a file in the present folder
    known = yaml.safe_load(NUMBERS.read_text())["cases"]
    assert list(known) == list(CASES)
    for name, numbers in known.items():
        agree(of_mujoco(document(name)), numbers)


def test_every_attribute_that_mujoco_has_is_read_or_known_not_to_matter():
    import mujoco  # takes a second

    schema: dict[str, set[str]] = {}
    path: list[str] = []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        found = re.match(r"( *)(?:\(world\))?(\w+) \(.\) *(.*)", line)
        if found:
            path[len(found[1]) // 3 :] = [found[2]]
        if path[1:2] and path[1] in ("compiler", "option", "default", "asset", "body", "actuator"):
            schema.setdefault(path[-1], set()).update((found[3] if found else line).split())
    assert len(schema) > 20
    for tag, words in MJCF_ATTRIBUTES.items():
        known = {*words.read.split(), *words.unused.split(), *(name for name, _ in words.neutral)}
        assert schema.get(tag, set()) <= known, tag


if __name__ == "__main__":
    import mujoco

    found = {name: of_mujoco(document(name)) for name in CASES}
    text = yaml.safe_dump(
        {"mujoco": mujoco.__version__, "cases": found}, sort_keys=False, default_flow_style=None
    )
    NUMBERS.write_text(text)
