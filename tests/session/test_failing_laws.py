"""A law that fails in flight is named with its line, whoever runs it."""

import signal
from pathlib import Path

import numpy as np
import pytest

from workbench.common import own_file
from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session

TEXT = (Path(__file__).parents[1] / "controllers/cascade.py").read_text(encoding="utf-8")
BEFORE = "    missing = "
LINE = TEXT[: TEXT.index(BEFORE)].count("\n") + 2
FAILURES = (
    (
        "m_x = m_x + 1e400 * 0.0",
        "update makes m_x nan: let it be a finite number; the flight broke o",
    ),
    ("m_x = m_x / (measured.p_WB[2] * 0.0)", "update fails: ZeroDivisionError: "),
    ("while up < 1e9: up *= 1.0", "does not end: it has an endless loop"),
    ("for k in range(int(1e9 * v[2])): up += 0.0", "does not end: it has an endless loop"),
)
"""What a law does above 0.3 m/s, and what is said of that line."""


def climbing(path: Path) -> Scenario:
    return Scenario(controller=str(path), script=[Action(velocity=[0.0, 0.0, 1.0])])


@pytest.fixture
def failing(tmp_path):
    """Return a function that writes a law with a line of failure, and returns a flight of it."""

    def write(line: str) -> tuple[Path, Session]:
        path = tmp_path / "mine.py"
        path.write_text(TEXT.replace(BEFORE, f"    if v[2] > 0.3:\n        {line}\n{BEFORE}"))
        return path, Session(climbing(path))

    return write


def complaint(session: Session, path: Path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        session.tick(3.0)
    assert 0.0 < session.time < 3.0
    assert isinstance(caught.value, FlightBrokenError) == ("nan" in str(caught.value))
    said = str(caught.value)
    assert said.startswith(f"{path}:{LINE}: "), said
    return said.removeprefix(f"{path}:{LINE}: ")


def test_python_names_the_line(failing, case):
    for line, said in FAILURES:
        with case(line):
            path, session = failing(line)
            assert complaint(session, path).startswith(said)


@pytest.mark.slow
def test_a_law_that_waits_is_named(failing, monkeypatch):
    """As for an answer of another program: nothing counts lines or turns meanwhile."""
    monkeypatch.setattr(own_file, "MAX_CALL_TIME_S", 5.0)
    before = signal.getsignal(signal.SIGALRM)
    path, session = failing("import time; time.sleep(3600.0)")
    assert complaint(session, path).startswith("update has not returned for 5 s: let it end")
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_what_is_flown_until_then_is_kept(failing):
    _, session = failing("m_x = m_x + 1e400 * 0.0")
    with pytest.raises(FlightBrokenError):
        session.tick(3.0)
    recording = session.recording()
    assert recording.v_WB[-1, 2] > 0.29
    # the update that fails ends the flight, so no rotor gets what it computed
    assert np.isfinite(recording.commanded_speeds).all()
    assert recording.time[-1] == session.time


def test_a_gain_that_a_law_cannot_design_with_leaves_the_one_before(tmp_path):
    path = tmp_path / "designing.py"
    path.write_text(
        f"{TEXT}\nDESIGNED = ['half']\n\n\ndef design(vehicle, g, dt):\n"
        "    if g.k_place > 1.0:\n        raise ValueError('too far')\n"
        "    return [0.5 * g.k_place]\n"
    )
    session = Session(Scenario(controller=str(path)))
    session.set("k_place", 0.9)
    with pytest.raises(WorkbenchError, match="too far"):
        session.do(Action(set={"k_place": 2.0, "k_speed": 3.0}))
    assert session.get("k_place") == 0.9
    assert session.get("k_speed") == 2.5
    session.tick(0.1)


def test_a_payload_and_gains_that_a_law_cannot_design_with_together_leave_those_before(tmp_path):
    path = tmp_path / "designing.py"
    path.write_text(
        f"{TEXT}\nDESIGNED = ['mass']\n\n\ndef design(vehicle, g, dt):\n"
        "    if vehicle.payload > 0.05 and g.k_place > 0.5:\n"
        "        raise ValueError('too heavy')\n"
        "    return [vehicle.mass]\n"
    )
    session = Session(Scenario(controller=str(path)))
    session.set("k_place", 0.9)
    before = session.parameters()
    for refused in ({"known_payload_mass": 0.1}, {"known_payload_mass": 0.1, "k_place": 0.6}):
        with pytest.raises(WorkbenchError, match="too heavy"):
            session.do(Action(set={"payload_mass": 0.1, **refused}))
        assert session.parameters() == before
    known = session._bench.computer._known(session._live.context_of(session._bench.computer))
    assert known.payload == 0.0
    session.do(Action(set={"payload_mass": 0.1, "known_payload_mass": 0.1, "k_place": 0.4}))
    assert session.get("known_payload_mass") == 0.1
