"""How fast vehicles with joints fly: `python benchmarks/joints.py`.

Simulated over processor time of hovers, in the air unless it says otherwise. The first row is the
rigid drone that most others are made of.
"""

import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from spread import Spread, spread, text

from workbench.common.resources import models_dir
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

ROUNDS, SLICE = 6, 1.0
"""Of each, and what it flies in a turn [s]."""
HIGH = ScenarioStart(position=[0.0, 0.0, 3.0])
LIMBS = """<robot name="limbs" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:include filename="$(find dh_drone)/drone.urdf.xacro"/>
  <xacro:macro name="limb" params="name parent place i last">
    <link name="${{name}}_${{i}}"><inertial><origin xyz="0 0 -0.04"/><mass value="0.03"/>
      <inertia ixx="2e-5" iyy="2e-5" izz="5e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="${{name}}_joint_${{i}}" type="revolute">
      <parent link="${{parent}}"/><child link="${{name}}_${{i}}"/>
      <origin xyz="${{place}}"/><axis xyz="${{'0 1 0' if i % 2 else '1 0 0'}}"/>
      <limit lower="-2" upper="2" effort="5" velocity="3"/>
      <dynamics armature="0.001"/><servo kind="position"/>
    </joint>
    <xacro:if value="${{i &lt; last}}">
      <xacro:limb name="${{name}}" parent="${{name}}_${{i}}" place="0 0 -0.08" i="${{i + 1}}"
                  last="${{last}}"/>
    </xacro:if>
  </xacro:macro>
  {limbs}
</robot>"""
LIMB = '<xacro:limb name="{}" parent="base_link" place="{} {} -0.05" i="1" last="{}"/>'


@dataclass(frozen=True)
class JointedFlight:
    """A hover of a vehicle with joints, with the least that its real-time factor must be."""

    name: str
    model: str
    mark: float
    args: dict[str, str] = field(default_factory=dict)
    start: ScenarioStart = field(default_factory=lambda: HIGH)
    settings: dict[str, float] = field(default_factory=dict)
    script: tuple[Action, ...] = ()


FLIGHTS = (
    JointedFlight("dh_drone, rigid", "dh_drone", 0.0),
    JointedFlight("load on a cable", "slung_load", 2.0),
    JointedFlight("load on 15 links", "slung_load", 0.5, {"links": "15"}),
    JointedFlight("gimbal", "gimbal", 2.0),
    JointedFlight("tricopter", "tricopter", 2.0),
    JointedFlight("two-link arm, crate held", "manipulator", 1.0),
    JointedFlight(
        "two-link arm, crate left on the ground",
        "manipulator",
        2.0,
        start=ScenarioStart(position=[0.0, 0.0, 0.3]),
        settings={"open_hooks": 1.0},
        script=(Action(go_to=[0.0, 0.0, 3.0]),),
    ),
    JointedFlight("landing gear, in the air", "landing_gear", 2.0),
    JointedFlight(
        "landing gear, on the ground", "landing_gear", 1.0, start=ScenarioStart(mode="off")
    ),
    JointedFlight("arm of 7 joints", LIMB.format("arm", 0, 0, 7), 0.5),
    JointedFlight(
        "four legs of 3 joints",
        "".join(
            LIMB.format(f"leg{2 * (x > 0) + (y > 0)}", x, y, 3)
            for x in (-0.1, 0.1)
            for y in (-0.1, 0.1)
        ),
        0.5,
    ),
)


@dataclass(frozen=True)
class JointedRow:
    """What was measured of one.

    Attributes:
        name: what flies.
        fastest_mode: rate of its fastest mode of joints [rad/s], 0 without joints.
        real_time_factor: simulated time over processor time.
        mark: the least that the median must be.
    """

    name: str
    fastest_mode: float
    real_time_factor: Spread
    mark: float


def measure() -> list[JointedRow]:
    """Return a row for each flight."""
    with tempfile.TemporaryDirectory() as folder:
        return [_measured(each, Path(folder)) for each in FLIGHTS]


def _measured(flight: JointedFlight, folder: Path) -> JointedRow:
    model, packages = flight.model, {"dh_drone": str(models_dir() / "dh_drone")}
    if model.startswith("<"):
        path = folder / f"{flight.name.replace(' ', '-')}.urdf.xacro"
        path.write_text(LIMBS.format(limbs=model))
        model = str(path)
    vehicle = VehicleConfig(model=model, args=flight.args, packages=packages)
    scenario = Scenario(vehicle=vehicle, start=flight.start, script=list(flight.script))
    session = Session(scenario, flight.settings)
    session.tick(SLICE)
    paces = []
    for _ in range(ROUNDS):
        begun = time.process_time()
        session.tick(SLICE)
        paces.append(SLICE / (time.process_time() - begun))
    modes = session._bench.airframe.modes
    return JointedRow(flight.name, modes[0].rate if modes else 0.0, spread(paces), flight.mark)


def show(rows: list[JointedRow]) -> None:
    """Print a line for each flight."""
    print(f"{'':40} fastest mode, rad/s   times real time          mark")
    for row in rows:
        print(
            f"{row.name:40} {row.fastest_mode:19.0f}   {text(row.real_time_factor):24} "
            f"{row.mark:4.1f}"
        )


if __name__ == "__main__":
    show(measure())
