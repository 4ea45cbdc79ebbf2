"""Opening, closing and recording in the real window: nothing is lost without a word."""

import shutil
from pathlib import Path

import pytest
from PyQt6.QtCore import QMimeData, QPointF, Qt, QUrl
from PyQt6.QtGui import QCloseEvent, QDropEvent
from PyQt6.QtWidgets import QApplication, QDialogButtonBox, QFileDialog, QLineEdit, QMessageBox

from tests.installed import readable
from workbench.common.resources import find_scenario, find_world
from workbench.gains.gains import load_gains
from workbench.gui.arguments_dialog import ArgumentsDialog
from workbench.gui.main_window import MainWindow
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.logs.record import read_log
from workbench.plant.formats.xacro import XacroArgument

LIMIT = 240_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
GAIN = "max_climb_rate"
"""It needs nobody who judges it, so that no test waits for the analyst."""


class FrameClose(QCloseEvent):
    """What the window's frame sends; a test has no other way to send what is spontaneous."""

    def spontaneous(self):
        return True


class User:
    """Who sits in front of the window."""

    def __init__(self, qtbot, window, told):
        self.qtbot, self.window, self.told = qtbot, window, told
        self.flight = window.workspace.flight

    def until(self, so) -> None:
        self.qtbot.waitUntil(lambda: bool(so()), timeout=LIMIT)

    def press(self, key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
        if QApplication.activeWindow() is None:  # no window manager does it once a dialog is gone
            self.window.activateWindow()
            self.until(self.window.isActiveWindow)
        self.qtbot.keyClick(QApplication.focusWidget() or self.window, key, modifier)

    def flies_on(self) -> None:
        """Wait until the present flight has gone on for a while."""
        live, now = self.flight.live, self.flight.view.snapshot.time
        self.until(lambda: self.flight.view.snapshot.time > now + 0.2)
        assert self.flight.live is live and self.flight.view.phase is Phase.FLYING

    def drop(self, path) -> None:
        mime = QMimeData()
        mime.setUrls([QUrl.fromLocalFile(str(path))])
        action, place = Qt.DropAction.CopyAction, QPointF(10.0, 10.0)
        event = QDropEvent(place, action, mime, LEFT, Qt.KeyboardModifier.NoModifier)
        self.window.dropEvent(event)

    def hears(self, words) -> None:
        """Wait until something is told."""
        self.until(lambda: [each for each in self.told if words in each.what])

    def tune(self) -> float:
        """Type a gain, keep it, and return it."""
        self.window.show_screen("tuning")
        gains, panel = self.window.stack.current.gains, self.window.stack.current.panel
        self.until(lambda: GAIN in gains.flown and GAIN in panel.rows)
        value = round(gains.flown[GAIN] * 1.1, 2)
        field = panel.rows[GAIN].field
        field.setFocus()
        field.selectAll()
        self.qtbot.keyClicks(field, f"{value:g}".replace(".", ","))
        self.qtbot.keyClick(field, Qt.Key.Key_Return)
        self.until(lambda: gains.flown[GAIN] == value)
        self.press(Qt.Key.Key_K, CONTROL)
        self.until(lambda: gains.kept[GAIN] == value)
        return value

    def question(self) -> QMessageBox | None:
        boxes = [each for each in self.window.findChildren(QMessageBox) if each.isVisible()]
        return boxes[-1] if boxes else None

    def answer(self, kind) -> None:
        """Press a button of the question, once it is asked."""
        self.until(self.question)
        self.qtbot.mouseClick(self.question().button(kind), LEFT)
        self.until(lambda: self.question() is None)


@pytest.fixture
def window(qtbot, workspace, tmp_path):
    workspace.preferences.set("log_folder", str(tmp_path / "logs"))
    made = MainWindow(workspace, first="home", view3d=False)
    qtbot.addWidget(made)
    made.control.fly(Choice("hover"))
    made.show()
    made.activateWindow()
    qtbot.waitUntil(lambda: workspace.flight.is_flying, timeout=LIMIT)
    qtbot.waitUntil(lambda: made.stack.name == "home", timeout=LIMIT)
    yield made
    made.close()


@pytest.fixture
def user(qtbot, window, told):
    return User(qtbot, window, told)


@pytest.mark.slow
def test_a_file_that_cannot_be_flown_ends_nothing(user, window, tmp_path):
    """Neither the flight, nor the kept gains, nor what Reset or another file begin."""
    value = user.tune()
    gains = window.stack.current.gains
    discard = QMessageBox.StandardButton.Discard
    bad = tmp_path / "bad.urdf"
    bad.write_text("<robot name='bad'><link name='a'/></robot>")
    user.drop(bad)
    user.answer(discard)
    user.hears("bad.urdf")
    assert "The present flight continues" in user.told[-1].remedy
    user.flies_on()
    assert gains.kept[GAIN] == gains.flown[GAIN] == value
    user.press(Qt.Key.Key_R, CONTROL)
    user.until(lambda: gains.flown[GAIN] != value)
    user.flies_on()
    before = user.flight.live
    user.drop(find_world("room"))
    user.answer(discard)  # the gains that were kept are in no file
    user.until(lambda: user.flight.live is not before)
    assert user.flight.view.scenario.world.endswith("room.yaml")
    assert user.flight.view.vehicle.name == "dh_drone"
    assert [each.what for each in user.told if "bad.urdf" in each.what] == [
        each.what for each in user.told if each.severity.value != "note"
    ]


def test_tuned_gains_are_asked_about_before_they_are_lost(user, window, tmp_path):
    """Ctrl+Q, the window's frame, and another flight: Cancel, Save and Discard."""
    value = user.tune()
    kinds = QMessageBox.StandardButton
    user.press(Qt.Key.Key_Q, CONTROL)
    user.answer(kinds.Cancel)
    assert window.isVisible()
    user.flies_on()
    by_frame = FrameClose()
    window.closeEvent(by_frame)
    assert not by_frame.isAccepted()
    user.answer(kinds.Cancel)
    assert window.isVisible()
    window.actions_by_name["open_scenario"].trigger()
    choose(user, window, find_scenario("windy"))
    user.answer(kinds.Cancel)
    user.flies_on()
    assert user.flight.what == Choice("hover")
    user.press(Qt.Key.Key_Q, CONTROL)
    user.until(user.question)
    user.qtbot.mouseClick(user.question().button(kinds.Save), LEFT)
    saved = tmp_path / "tuned.yaml"
    choose(user, window, saved)
    user.until(lambda: not window.isVisible())
    assert load_gains(saved).gains[GAIN] == value


@pytest.mark.slow
def test_gains_that_are_saved_or_as_they_began_are_not_asked_about(user, window, tmp_path):
    user.tune()
    user.press(Qt.Key.Key_S, CONTROL)
    choose(user, window, tmp_path / "tuned.yaml")
    user.hears("Saved")
    user.press(Qt.Key.Key_Q, CONTROL)
    assert not window.isVisible()
    assert user.question() is None


def choose(user, window, path) -> None:
    """Type a path into the file dialog that is open."""
    dialogs = lambda: [d for d in window.findChildren(QFileDialog) if d.isVisible()]  # noqa: E731
    user.until(dialogs)
    field = dialogs()[0].findChild(QLineEdit)
    field.setText(str(path))  # typed letter by letter, a list of files would stand above it
    user.qtbot.keyClick(field, Qt.Key.Key_Return)
    user.until(lambda: not dialogs())


@pytest.mark.parametrize(
    "loss",
    ["deleted", *(pytest.param(loss, marks=pytest.mark.slow) for loss in ("moved", "in a pause"))],
)
def test_a_recording_that_loses_its_file_is_told(user, window, loss, tmp_path):
    """It is told while it is written, not as a success when it is stopped."""
    user.press(Qt.Key.Key_R, CONTROL | SHIFT)
    user.until(lambda: window.recorder.is_recording)
    path = Path(window.recorder.path)
    if loss == "in a pause":
        user.press(Qt.Key.Key_F9)
        user.until(lambda: user.flight.view.phase is Phase.PAUSED)
    if loss == "moved":
        path.rename(tmp_path / "moved.mcap")
    else:
        shutil.rmtree(path.parent)
    user.hears("recording has ended")
    assert path.name in user.told[-1].what and "moved or deleted" in user.told[-1].what
    assert "record again" in user.told[-1].remedy
    assert not window.recorder.is_recording
    assert not window.actions_by_name["record"].isChecked()
    assert not [each for each in user.told if each.what.startswith("recorded")]
    if loss == "moved":
        assert read_log(tmp_path / "moved.mcap").scenario().title == "Hover for a minute"


def test_a_recording_that_is_stopped_is_told_once_and_whole(user, window):
    user.press(Qt.Key.Key_R, CONTROL | SHIFT)
    user.until(lambda: window.recorder.is_recording)
    path = Path(window.recorder.path)
    user.flies_on()
    user.press(Qt.Key.Key_R, CONTROL | SHIFT)
    user.until(lambda: not window.recorder.is_recording)
    user.flies_on()
    assert [each.what for each in user.told] == [f"recorded {path}"]
    assert path.read_bytes().endswith(b"\x89MCAP0\r\n")


@pytest.mark.slow
def test_a_drone_without_sensors_opens_with_all_that_it_has(user, window, tmp_path):
    """Opened from a flight with sensors and rates of their own."""
    plain = tmp_path / "plain.urdf"
    plain.write_text(PLAIN)
    before = user.flight.live
    user.drop(find_scenario("all-sensors"))
    user.until(lambda: user.flight.live is not before)
    before = user.flight.live
    user.drop(plain)
    user.until(lambda: user.flight.live is not before)
    assert user.flight.view.vehicle.name == "plain"
    assert user.flight.view.vehicle.sensors == ()
    assert not [each for each in user.told if each.severity.value != "note"]


def test_a_file_opens_once_all_arguments_have_values(qtbot):
    given = []
    arguments = (XacroArgument("mass"), XacroArgument("arm", "0.2"))
    dialog = ArgumentsDialog("sized.urdf.xacro", arguments, given.append)
    dialog.show()
    assert {name: line.text() for name, line in dialog.lines.items()} == {"mass": "", "arm": "0.2"}
    button = dialog.buttons.button(QDialogButtonBox.StandardButton.Open)
    assert not button.isEnabled()
    qtbot.keyClicks(dialog.lines["mass"], "1.25")
    qtbot.mouseClick(button, LEFT)
    assert given == [{"mass": "1.25"}]


@pytest.mark.slow
def test_a_xacro_file_with_arguments_asks_for_them(user, window, tmp_path):
    """Dropped, cancelled, dropped again, and opened by mouse and keyboard."""
    file = tmp_path / "sized.urdf.xacro"
    file.write_text(SIZED)
    dialogs = lambda: [d for d in window.findChildren(ArgumentsDialog) if d.isVisible()]  # noqa: E731
    before = user.flight.live
    user.drop(file)
    user.until(dialogs)
    user.qtbot.keyClick(dialogs()[0].lines["mass"], Qt.Key.Key_Escape)
    user.hears("sized.urdf.xacro was not opened: it needs values for mass")
    user.until(lambda: not dialogs())
    user.flies_on()
    user.drop(file)
    user.until(dialogs)
    dialog = dialogs()[0]
    assert {name: line.text() for name, line in dialog.lines.items()} == {"mass": "", "arm": "0.2"}
    button = dialog.buttons.button(QDialogButtonBox.StandardButton.Open)
    assert not button.isEnabled()
    user.qtbot.keyClicks(dialog.lines["mass"], "1.25")
    user.qtbot.mouseClick(button, LEFT)
    user.until(lambda: user.flight.live is not before)
    assert user.flight.view.scenario.vehicle.args == {"mass": "1.25"}
    assert user.flight.view.vehicle.mass == pytest.approx(1.25)
    assert not [each for each in user.told if "--arg" in each.what + each.remedy]


PUBLISHED = Path(__file__).resolve().parents[3] / "shared" / "models"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    readable(["gym_pybullet_drones/cf2x.urdf", "rotors_description/urdf/hummingbird_base.xacro"]),
)
def test_published_drones_open(user, window, name):
    """A xacro file's arguments are given in the dialog where it asks for some."""
    file = PUBLISHED / name
    if not file.is_file():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    before = user.flight.live
    user.drop(file)
    dialogs = lambda: [d for d in window.findChildren(ArgumentsDialog) if d.isVisible()]  # noqa: E731
    user.until(lambda: user.flight.live is not before or dialogs())
    for dialog in dialogs():
        for argument, line in dialog.lines.items():
            if not line.text():
                user.qtbot.keyClicks(line, "hummingbird" if "name" in argument else "false")
        open_button = dialog.buttons.button(QDialogButtonBox.StandardButton.Open)
        user.qtbot.mouseClick(open_button, LEFT)
    user.until(lambda: user.flight.live is not before)
    assert not [each for each in user.told if each.severity.value == "failure"]


def drone(mass, arm) -> str:
    """Return the description of a drone with four rotors."""
    rotors = "".join(
        f"""
  <link name="rotor_{at}"/>
  <joint name="rotor_{at}_joint" type="continuous">
    <parent link="base_link"/><child link="rotor_{at}"/>
    <origin xyz="{x} {y} 0.05"/><axis xyz="0 0 1"/>
  </joint>
  <gazebo><plugin name="motor_{at}" filename="librotors_gazebo_motor_model.so">
    <jointName>rotor_{at}_joint</jointName><linkName>rotor_{at}</linkName>
    <turningDirection>{"ccw" if at < 2 else "cw"}</turningDirection>
    <timeConstantUp>0.0125</timeConstantUp><timeConstantDown>0.025</timeConstantDown>
    <maxRotVelocity>1100</maxRotVelocity><motorConstant>8.5e-06</motorConstant>
    <momentConstant>0.016</momentConstant><motorNumber>{at}</motorNumber>
  </plugin></gazebo>"""
        for at, (x, y) in enumerate(
            ((arm, f"-{arm}"), (f"-{arm}", arm), (arm, arm), (f"-{arm}", f"-{arm}"))
        )
    )
    return f"""
  <link name="base_link"><inertial>
    <mass value="{mass}"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>{rotors}
</robot>"""


PLAIN = f"<robot name='plain'>{drone(1.0, 0.2)}"
SIZED = (
    "<robot name='sized' xmlns:xacro='http://www.ros.org/wiki/xacro'>"
    "<xacro:arg name='mass'/><xacro:arg name='arm' default='0.2'/>"
    + drone("$(arg mass)", "$(arg arm)")
)
