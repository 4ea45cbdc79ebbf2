"""How the shipped laws recover from any attitude: `python benchmarks/attitudes.py [LAW ...]`.

Each flies from 1,000 random attitudes, and from all turns by multiples of 90° about each axis, at
rest and at hover speed of the rotors, 300 m above the ground. Recovered is who is within 15° of
upright and turns slower than 1 rad/s in the last of 12 s. Laws compile first, up to a minute each,
so it is not part of `make bench`. The exit code is 1 if a law whose page promises to recover does
not, or raises.
"""

import itertools
import math
import sys
from dataclasses import dataclass

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.control.installed_laws import installed_laws
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

COUNT, SEED, DURATION, HEIGHT = 1000, 1, 12.0, 300.0
UPRIGHT, SLOW = math.radians(15.0), 1.0
"""Limits of tilt [rad] and turning [rad/s] of a vehicle that has recovered."""
RECOVERS_TO = {"mellinger": math.radians(90.0)}
"""Tilt beyond which a law need not recover, as its docstring says [rad]; any, for other laws."""


@dataclass(frozen=True)
class Outcome:
    """A flight: its first tilt [rad], whether it recovered, its fall [m], and what was raised."""

    tilt: float
    recovered: bool
    fall: float
    error: str = ""


def starts() -> list[list[float]]:
    """Return roll, pitch and yaw of all starts, the exact ones first [rad]."""
    quarters = [turn * math.pi / 2.0 for turn in range(-1, 3)]
    exact = [list(angles) for angles in itertools.product(quarters, repeat=3)]
    rng = np.random.default_rng(SEED)
    q = rng.normal(size=(COUNT, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return [*exact, *(RollPitchYaw(Quaternion(each)).vector().tolist() for each in q)]


def fly(session: Session, angles: list[float]) -> Outcome:
    """Fly from an attitude."""
    session.scenario.start = ScenarioStart(position=[0.0, 0.0, HEIGHT], roll_pitch_yaw=angles)
    tilt = math.acos(max(-1.0, min(1.0, math.cos(angles[0]) * math.cos(angles[1]))))
    try:
        session.reset()
        session.set("max_height", 500.0)
        session.tick(DURATION)
    except (WorkbenchError, ArithmeticError) as error:
        return Outcome(tilt, False, math.nan, repr(error))
    flown = session.recording()
    last = flown.time > DURATION - 1.0
    q, w = flown.q_WB[last], flown.w_WB[last]
    upright = 1.0 - 2.0 * (q[:, 1:3] ** 2).sum(axis=1) > math.cos(UPRIGHT)
    slow = np.linalg.norm(w, axis=1) < SLOW
    return Outcome(tilt, bool(np.all(upright & slow)), HEIGHT - float(flown.p_WB[:, 2].min()))


def main() -> int:
    """Print a line for each law."""
    laws = sys.argv[1:] or list(installed_laws())
    missed = 0
    print("law          recovered  of which must  raised  largest fall  least tilt not recovered")
    for law in laws:
        scenario = Scenario(controller=law, start=ScenarioStart(position=[0.0, 0.0, HEIGHT]))
        scenario.duration = 1e6
        session = Session(scenario)
        found = [fly(session, angles) for angles in starts()]
        limit = RECOVERS_TO.get(law, math.inf)
        must = [each for each in found if each.tilt <= limit + 1e-9]
        missed += sum(not each.recovered for each in must) + any(each.error for each in found)
        falls = [each.fall for each in must if each.recovered]
        lost = [math.degrees(each.tilt) for each in found if not each.recovered]
        print(
            f"{law:12s} {sum(each.recovered for each in found):4d}/{len(found)}"
            f"  {sum(each.recovered for each in must):4d}/{len(must)}"
            f"  {sum(bool(each.error) for each in found):12d}  {max(falls):10.1f} m"
            f"  {f'{min(lost):.0f}°' if lost else '-':>12s}",
            flush=True,
        )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
