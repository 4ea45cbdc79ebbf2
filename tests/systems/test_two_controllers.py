"""Laws whose functions have the same names, flown in one process."""

from pathlib import Path

import numpy as np

from workbench.common.resources import controllers_dir
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session


def flown(controller: str) -> tuple[bytes, object]:
    """Return the state after a step, and that of the law."""
    session = Session(Scenario(controller=controller))
    session.command([1.0, 0.0, 0.0], 0.0)
    session.tick(0.5)
    states = session.checkpoint().systems
    (path,) = (path for path in states if path.endswith("::controller"))
    return np.array(session.state()).tobytes(), states[path].state


def test_each_law_flies_as_if_it_were_alone(tmp_path: Path):
    own = tmp_path / "pd.py"
    text = (controllers_dir() / "pd.py").read_text(encoding="utf-8")
    changed = text.replace("g.kp_velocity_x * e[0]", "2.0 * g.kp_velocity_x * e[0]")
    assert changed != text
    own.write_text(changed, encoding="utf-8")
    shipped, mine = flown("pd"), flown(str(own))
    assert shipped[0] != mine[0]
    assert (flown("pd"), flown(str(own))) == (shipped, mine)
