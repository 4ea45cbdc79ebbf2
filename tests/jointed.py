"""Drones with joints for tests: a base with rotors given by position, and links below it."""

from pathlib import Path

import numpy as np

ARM = 0.2
"""Of each rotor along x and y [m]."""
SPHERE = 2e-4
"""Moments of inertia of each link about its centre [kg m²]."""


def link(name: str, mass: float, p=(0.0, 0.0, 0.0), moments=(SPHERE,) * 3, shape="") -> str:
    """Return a link with its centre of mass at a place, and a shape that touches, at its origin."""
    xx, yy, zz = moments
    touches = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return (
        f'<link name="{name}"><inertial><origin xyz="{p[0]} {p[1]} {p[2]}"/><mass value="{mass}"/>'
        f'<inertia ixx="{xx}" iyy="{yy}" izz="{zz}" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"{touches}</link>"
    )


def joint(
    name: str, kind: str, parent: str, child: str, p=(0, 0, 0), axis=(0, 1, 0), more=""
) -> str:
    """Return a joint at a place of its parent."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{p[0]} {p[1]} {p[2]}"/><axis xyz="{axis[0]} {axis[1]} {axis[2]}"/>{more}'
        "</joint>"
    )


def drone(
    folder: Path, parts: str, mass=1.0, moments=(0.01, 0.012, 0.02), thrust=1e-5, shape=""
) -> str:
    """Write a quadrotor with parts below `base`, and return its path.

    Its rotors push at the height of its centre of mass; `thrust` is their motor constant, and
    `shape` that of the base.
    """
    path = folder / "jointed.urdf"
    base = link("base", mass, moments=moments, shape=shape)
    path.write_text(f'<robot name="jointed">{base}{parts}</robot>')
    places = [(x, y) for x in (ARM, -ARM) for y in (ARM, -ARM)]
    turns = ["ccw" if x * y < 0 else "cw" for x, y in places]
    rows = "".join(
        f"  - {{name: r{i}, position: [{x}, {y}, 0.0], direction: {turn}}}\n"
        for i, ((x, y), turn) in enumerate(zip(places, turns, strict=True))
    )
    path.with_name("jointed.rotors.yaml").write_text(
        f"defaults: {{motor_constant: {thrust}, moment_constant: 0.016, max_rot_velocity: 1000.0,\n"
        f"  time_constant_up: 0.0125, time_constant_down: 0.025}}\nrotors:\n{rows}"
    )
    return str(path)


def crossings(time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the times at which an angle rises through zero."""
    rises = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    share = angle[rises] / (angle[rises + 1] - angle[rises])
    return time[rises] - share * (time[rises + 1] - time[rises])
