"""A package that is not ours adds to the workbench, and a broken one is named in a sentence."""

import gzip
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PACKAGES = ROOT / "examples" / "packages"


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Return a folder with the installed packages of examples/packages."""
    source, target = (tmp_path_factory.mktemp(name) for name in ("source", "installed"))
    shutil.copytree(PACKAGES, source, dirs_exist_ok=True)
    packages = [path.parent for path in source.rglob("pyproject.toml")]
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index"]
    subprocess.run([*pip, "--no-build-isolation", "--target", target, *packages], check=True)
    return target


COMMANDS = """
import contextlib, io, json, sys
from workbench.commands.cli import main
done = []
for words in json.loads(sys.argv[1]):
    out, error = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        try:
            code = main(words)
        except SystemExit as end:
            code = end.code
    done.append((code, out.getvalue(), error.getvalue()))
print(json.dumps(done))
"""


def python(installed, code, *words):
    """Run code where the packages are installed, and return the finished process."""
    there = os.environ | {"PYTHONPATH": f"{ROOT}:{installed}"}
    words = [sys.executable, "-c", code, *words]
    return subprocess.run(words, env=there, capture_output=True, text=True, timeout=300.0)


def run(installed, *commands):
    """Return exit code, output and errors of each command; one process runs them all."""
    done = python(installed, COMMANDS, json.dumps(commands))
    assert done.returncode == 0, done.stderr
    return [tuple(each) for each in json.loads(done.stdout)]


def test_a_strangers_package_adds_a_command(installed):
    model = str(ROOT / "models" / "dh_drone" / "drone.urdf.xacro")
    counted, listed = run(installed, ("rotor-count", model), ("--help",))
    assert counted == (0, "4\n", "")
    assert "Print how many rotors a description has." in listed[1]


def test_a_strangers_package_adds_a_law_and_its_gain_files(installed, tmp_path):
    sheet, other, wrong = (tmp_path / f"{name}.sheet" for name in ("a", "other", "wrong"))
    other.write_text("p_tilt=130\n")
    wrong.write_text("p_tilt=1e9\n")
    flight = ("fly", "hover", "--controller", "soft", "--duration", "0.1", "--no-plots")
    export = ("gains", "export", str(sheet), "--for", "sheet", "--no-margins")
    shown, flown, exported, imported, refused, unknown = run(
        installed,
        ("controllers", "soft"),
        (*flight, "--output", str(tmp_path)),
        (*export, "--set", "p_tilt=120"),
        ("gains", "import", str(other), "--no-margins"),
        ("gains", "import", str(wrong), "--no-margins"),
        (*export, "--controller", "pd"),
    )
    assert shown[0] == 0
    assert flown[0] == 0, flown[2]
    code, said, error = exported
    assert code == 0 and "p_tilt" in said and f"wrote {sheet}" in error
    assert sheet.read_text() == "p_velocity=3\np_tilt=120\nd_tilt=20\np_yaw=4\n"
    code, said, error = imported
    assert (code, error) == (0, "") and "law soft" in said and "1 of 1 gains differ" in said
    code, _, error = refused
    assert code == 2 and "p_tilt is out of range" in error
    code, _, error = unknown
    assert code == 2 and "what the gains of soft mean is not known" in error


def test_a_law_in_the_wrong_group_is_named(installed):
    module = installed / "soft_law.py"
    text = module.read_text(encoding="utf-8")
    try:
        module.write_text("def program(vehicle, dt):\n    pass\n", encoding="utf-8")
        ((code, _, error),) = run(installed, ("controllers", "soft"))
        assert code == 2 and "a law with a program belongs to workbench.law_programs" in error
        module.write_text(text.replace("(vehicle.mass * f[2], m_x", "(m_x"), encoding="utf-8")
        ((code, _, error),) = run(installed, ("controllers", "soft"))
        assert code == 2 and "soft_law.py" in error and "update returns" in error
    finally:
        module.write_text(text, encoding="utf-8")


def test_a_strangers_package_adds_a_format_and_rotors(installed, tmp_path):
    path, wrong = tmp_path / "quad.frame", tmp_path / "wrong.frame"
    path.write_text("1.2 0.17")
    wrong.write_text("heavy")
    read, refused = run(installed, ("inspect", str(path), "--json"), ("inspect", str(wrong)))
    code, printed, error = read
    assert (code, error) == (0, "")
    said = json.loads(printed)
    assert (said["mass"], len(said["rotors"])) == (1.2, 4)
    assert any("3 times the weight" in str(each) for each in said["warnings"])
    code, _, error = refused
    assert code == 2 and f"{wrong}: give it a mass and a distance" in error


def test_a_format_that_is_none_or_fails_leaves_the_others_as_they_are(installed, tmp_path):
    module = installed / "frame_format.py"
    text = module.read_text(encoding="utf-8")
    path = tmp_path / "a.xml"
    path.write_text('<robot name="a"><link name="b"/></robot>')
    said = "frame_format:FRAME is no DescriptionFormat; left out"
    for broken, reason in (("FRAME = ROTORS = 1", said), ("import nothing_here", "cannot be load")):
        module.write_text(broken, encoding="utf-8")
        ((code, _, error),) = run(installed, ("inspect", str(path)))
        assert code == 2 and reason in error and "no rotors are declared" in error
    module.write_text(text, encoding="utf-8")


def test_a_strangers_package_reads_logs(installed, tmp_path):
    log, packed, other = (tmp_path / name for name in ("climb.hgt", "climb.hgt.gz", "deep.hgt"))
    log.write_text("HEIGHT\n" + "".join(f"{0.1 * i:.1f} {i}\n" for i in range(20)))
    packed.write_bytes(gzip.compress(log.read_bytes()))
    other.write_bytes(b"DEPTH")
    *read, unknown = run(installed, *(("log", str(path)) for path in (log, packed, other)))
    for code, out, error in read:
        assert code == 0, error
        assert out.startswith("climb: height log, firmware not known\n1.90 s, 1 signals")
    assert "a height sensor's .hgt" in unknown[2]


SHOW = """
from pathlib import Path
from types import SimpleNamespace
from PyQt6.QtWidgets import QApplication
from workbench.gui.tuning.added_cards import added_cards
from workbench.gui.workspace import OpenedLog
app, log = QApplication([]), OpenedLog()
row = next(each for each in added_cards() if each.title == "Log name")
card = row.make(SimpleNamespace(log=log), None, None)
log.open(Path("flights/a.mcap"))
print(row.log_button, card.name.text(), "Open another log" in card.whatsThis())
"""


def test_a_strangers_package_adds_a_card(installed):
    done = python(installed, SHOW)
    assert (done.returncode, done.stdout) == (0, "&Name… a.mcap True\n"), done.stderr


AIRSPEED_MESSAGE = """
import sys
from pathlib import Path
from workbench import Scenario, SensorsConfig, Session, VehicleConfig
from workbench.link.ros_messages.library import package_files
print(package_files(Path("there"))[Path("there/dh_drone_msgs/msg/Airspeed.msg")], end="")
vehicle = VehicleConfig(sys.argv[1], packages={"dh_drone": sys.argv[2]})
session = Session(Scenario(vehicle=vehicle, sensors=SensorsConfig(use=["pitot"])))
session.tick(0.01)
print(*session.snapshot().others)
"""


def test_a_strangers_package_adds_a_sensor_and_its_signal(installed, tmp_path):
    """The drone hovers in wind of 4 m/s from ahead: that is the speed of the air at its tube."""
    path, log = tmp_path / "tube.urdf.xacro", tmp_path / "a.mcap"
    path.write_text((PACKAGES / "pitot" / path.name).read_text(encoding="utf-8"), encoding="utf-8")
    drone = ("--model", str(path), "--package", f"dh_drone={ROOT / 'models' / 'dh_drone'}")
    flight = ("fly", "hover", *drone, "--duration=0.5", "--sensors=airspeed", "--no-plots")
    settings = ("--set", "wind_x=-4", "--set", "airspeed_blocked=0.5", "--no-noise")
    files = ("--log", str(log), "--out", str(tmp_path))
    helped, done, listed, refused = run(
        installed,
        ("fly", "--help"),
        (*flight, *settings, *files),
        ("log", str(log)),
        (*flight, "--set", "airspeed_fault=4"),
    )
    assert "airspeed" in helped[1]
    code, said, error = done
    assert code == 0, error
    assert "pitot   airspeed        50         50.00" in said
    head, *rows = (tmp_path / "hover-pitot.csv").read_text().splitlines()
    assert head == "stamp [s],airspeed [m/s]"
    assert float(rows[0].split(",")[1]) == pytest.approx(2.0)
    code, said, error = listed
    assert code == 0 and re.search(r"^airspeed +airspeed +m/s +", said, re.MULTILINE), error
    code, _, error = refused
    assert code == 2 and "airspeed_fault" in error
    done = python(installed, AIRSPEED_MESSAGE, path, ROOT / "models" / "dh_drone")
    said = "# Airspeed.\nstd_msgs/Header header\nfloat32 airspeed # [m/s] in S\n"
    assert done.returncode == 0 and done.stdout.startswith(said), done.stderr
    assert done.stdout.removeprefix(said).startswith("AirspeedReading(stamp=0.0, frame='pitot'")


def test_a_sensor_of_another_kind_and_a_signal_with_a_taken_number_are_left_out(
    installed, tmp_path
):
    module = installed / "pitot.py"
    text = module.read_text(encoding="utf-8")
    kind, taken = "is no Sensor of the kind", "needs a name and a number of its own, 1000 or more"
    sensors = (
        ('kind = "airspeed"', 'kind = "air"', f"pitot:Pitot {kind} airspeed"),
        ("class Pitot(MeasuringSensor)", "class Pitot", f"pitot:Pitot {kind}"),
    )
    signal = ("AIRSPEED = Signal(", "AIRSPEED = dict(", "pitot:AIRSPEED is no Signal; left out")
    signals = (
        ("id=1001", "id=20", f"pitot:AIRSPEED {taken}"),
        ('name="airspeed"', 'name="imu"', f"pitot:AIRSPEED {taken}"),
    )
    flight = ("fly", "hover", "--duration=0.1", "--no-plots", f"--log={tmp_path / 'a.mcap'}")
    try:
        for old, new, reason in sensors:
            replace_in(module, text, old, new)
            [(code, _, error)] = run(installed, ("params",))
            assert code == 0 and reason in error, (reason, error)
        replace_in(module, text, *signal[:2])
        [(code, _, error)] = run(installed, flight)
        assert code == 0 and signal[2] in error, error
        for old, new, reason in signals:
            replace_in(module, text, old, new)
            error = python(installed, LIST_SIGNALS).stderr
            assert reason in error, (reason, error)
    finally:
        module.write_text(text, encoding="utf-8")


LIST_SIGNALS = "from workbench.link.drone_topics import drone_signals; drone_signals()"
"""As a flight does, which takes ten times as long to load."""


def replace_in(module, text, old, new):
    """Write a module with a text that has `new` in place of `old`."""
    assert old in text
    module.write_text(text.replace(old, new), encoding="utf-8")
    # Python takes a source of the same size within the same second for the compiled one
    shutil.rmtree(module.parent / "__pycache__", ignore_errors=True)


DRAW = """
import sys
from pathlib import Path
from PyQt6.QtCore import QSettings
from PyQt6.QtWidgets import QApplication
from workbench.gui.charts.curve import fixed_source
from workbench.gui.preferences import Preferences
from workbench.gui.visualization.chart_pane import ChartPane
from workbench.gui.visualization.layouts import ChartSpec
from workbench.gui.workspace import make_workspace

class Source:
    units = {"wind.wind.0": "m/s"}
    def series(self, name, since):
        return fixed_source(np.arange(100.0), np.arange(100.0) % 10)(since)

import numpy as np
app = QApplication([])
settings = QSettings(sys.argv[1], QSettings.Format.IniFormat)
workspace = make_workspace(Preferences(settings))
pane = ChartPane(workspace, ChartSpec("", ("wind.wind.0",), "histogram"), Source())
pane.show()
pane.chart.refresh(99.0)
[curve] = pane.chart.curves
density = curve.samples(-np.inf)[1]
print(curve.label, len(density), round(float(density.sum()) * 0.3, 6))
titles = [each.text() for each in pane.chart.extra_actions[0].menu().actions()]
print("Histogram" in titles, flush=True)
pane.close()
workspace.close()
"""


def test_a_strangers_package_adds_a_kind_of_chart(installed, tmp_path):
    done = python(installed, DRAW, str(tmp_path / "settings.ini"))
    assert (done.returncode, done.stdout) == (0, "wind x 30 1.0\nTrue\n"), done.stderr


def test_a_package_that_cannot_be_imported_is_named(installed):
    module = installed / "rotor_count.py"
    aside = module.rename(installed / "aside.py")
    try:
        (_, listed, _), (code, _, error), version = run(
            installed, ("--help",), ("rotor-count", "x.urdf"), ("--version",)
        )
        assert "rotor-count" not in listed
        assert code == 2
        assert "is in rotor_count of the package rotor-count, which cannot be loaded" in error
        assert version[0] == 0
        module.write_text('"""Without the function that the entry names."""\n')
        ((code, listed, error),) = run(installed, ("--help",))
        assert code == 0 and "linearize" in listed and "rotor-count" not in listed
        assert "the command 'rotor-count' is in rotor_count of the package rotor-count" in error
    finally:
        aside.rename(module)
