"""The 3-D view, with a stand-in for the web engine."""

import dataclasses
import json
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest
from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import QColor, QDesktopServices, QPainter
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QLineEdit, QVBoxLayout, QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import Series
from workbench.gui.command_action import make_actions
from workbench.gui.view3d import view3d_panel, web_engine
from workbench.gui.view3d.view3d_panel import (
    BLANK_PAGE_URL,
    BLANK_VIEW_TEXT,
    HIDABLE_PARTS,
    NOT_DRAWN_TEXT,
    PAGE_FAULT_TEXTS,
    PAGE_STATE_SCRIPT,
    PAGE_TIMEOUT_S,
    VIEW_ENDED_TEXT,
    VIEW_WAITING_TEXT,
    View3d,
)
from workbench.gui.view3d.web_engine import (
    CHROMIUM_FLAGS_VARIABLE,
    FORCE_GBM_VARIABLE,
    SMALL_HEAP_FLAG,
    can_use_gpu,
    load_web_view,
    missing_library,
    prepare_web_engine,
)
from workbench.live.messages import Pace, Phase
from workbench.live.orders import ShowPrediction

PAGE, OTHER = "http://localhost:7000", "http://localhost:7001"


class Web(QWidget):
    """A web view that notes where it was sent and what it was asked to do, and says how it does."""

    renderProcessTerminated = pyqtSignal(object, int)

    def __init__(self):
        super().__init__()
        self.setAcceptDrops(True)  # as the web engine does
        self.went, self.ran = [], []
        self.state = {"fault": "", "software": True, "connected": True, "pictures": 7}
        self.is_seen = True

    def setUrl(self, url):
        self.went.append(url.toString())

    def page(self):
        return self

    def runJavaScript(self, code, answered):
        self.ran.append(code)
        answered(json.dumps(self.state) if code == PAGE_STATE_SCRIPT and self.state else "")

    def paintEvent(self, event):
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor("white"))
        if self.is_seen:
            painter.fillRect(self.rect().adjusted(20, 20, -20, -20), QColor("red"))


def straight_log():
    """A log of 1 s, 2 m to the east."""
    time = np.linspace(0.0, 1.0, 101)
    values = {
        f"position_data.{axis}": each * np.ones(101)
        for axis, each in zip("yz", (0, 1), strict=True)
    }
    values["position_data.x"] = 2.0 * time
    signals = {name: Series(name, "m", time, each) for name, each in values.items()}
    return Flight("it", Path("it.mcap"), "", signals, end=1.0)


def no_engine():
    raise WorkbenchError("The 3-D view needs PyQt6-WebEngine.")


@pytest.fixture
def drawn(canned):
    return dataclasses.replace(canned.views[0], url=PAGE)


@pytest.fixture
def loaded():
    return []


@pytest.fixture
def actions(qtbot, workspace):
    window = QWidget()
    qtbot.addWidget(window)
    made = make_actions(window, defaultdict(lambda: lambda: None), workspace.keys)
    for name in HIDABLE_PARTS:
        made[name].setChecked(True)
    yield made
    window.close()


@pytest.fixture
def panel(qtbot, workspace, actions, loaded):
    def load():
        loaded.append(Web())
        return lambda: loaded[-1]

    made = View3d(workspace, actions, load)
    made.resize(400, 400)
    qtbot.addWidget(made)
    yield made
    made.close_view()


@pytest.fixture
def clock(monkeypatch):
    """A clock that stands, for the panel alone."""
    now = [100.0]
    monkeypatch.setattr(view3d_panel.time, "monotonic", lambda: now[0])
    return now


@pytest.fixture
def web(panel, show, drawn, qtbot, loaded, clock):
    """The web view of a page that is there."""
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded) and loaded[0].went == [PAGE], timeout=5000)
    panel._timer.stop()  # the tests look by hand
    return loaded[0]


def test_before_the_flight_it_says_so_and_loads_nothing(panel, qtbot, loaded):
    panel.show()
    qtbot.waitExposed(panel)
    assert panel.said == VIEW_WAITING_TEXT
    assert loaded == []


def test_the_page_is_opened_once_there_is_a_flight(panel, show, drawn, qtbot, loaded):
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded) and loaded[0].went == [PAGE], timeout=5000)
    assert panel.said == ""


def test_a_file_that_is_dropped_on_the_picture_is_left_to_the_window(
    panel, show, drawn, qtbot, loaded
):
    show(drawn)
    panel.show()
    qtbot.waitUntil(lambda: bool(loaded))
    assert not loaded[0].acceptDrops()


def test_hidden_it_loads_nothing(panel, show, drawn, qtbot, loaded):
    show(drawn)
    panel.wake()
    assert loaded == []
    panel.show()
    qtbot.waitUntil(lambda: bool(loaded), timeout=5000)


def test_another_flight_is_another_page(panel, show, drawn, qtbot, loaded):
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded), timeout=5000)
    show(dataclasses.replace(drawn, url=OTHER))
    assert loaded[0].went[-1] == OTHER
    assert len(loaded) == 1


def test_the_page_goes_with_its_flight(panel, show, drawn, qtbot, loaded):
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded), timeout=5000)
    show(dataclasses.replace(drawn, phase=Phase.ENDED, said="its process is gone"))
    assert panel.said == VIEW_ENDED_TEXT
    assert loaded[0].went[-1] == BLANK_PAGE_URL


def test_a_flight_that_is_not_drawn_says_how(panel, show, canned):
    panel.show()
    show(canned.views[0])
    assert panel.said == NOT_DRAWN_TEXT
    assert panel.plain.isVisible()  # Qt draws it itself


def test_without_the_engine_it_says_what_to_install_and_offers_the_browser(
    qtbot, workspace, actions, show, drawn, monkeypatch, told
):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: not opened.append(url.toString()))
    panel = View3d(workspace, actions, no_engine)
    qtbot.addWidget(panel)
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: "needs PyQt6-WebEngine" in panel.said, timeout=5000)
    qtbot.mouseClick(panel._browse, Qt.MouseButton.LeftButton)
    assert opened == [PAGE]
    assert told == []


def test_no_browser_is_a_notice_with_the_address(panel, show, drawn, monkeypatch, told):
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: False)
    panel.browse()
    assert told[-1].what == "there is no 3-D view yet"
    show(drawn)
    panel.browse()
    assert PAGE in told[-1].remedy


def test_a_flight_that_the_picture_slows_is_told_once(
    panel, show, drawn, qtbot, loaded, workspace, monkeypatch
):
    told, clock = [], [100.0]
    workspace.notices.told.connect(told.append)
    monkeypatch.setattr(view3d_panel.time, "monotonic", lambda: clock[0])
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded), timeout=5000)
    for number in range(4):
        clock[0] += 3.0
        show(dataclasses.replace(drawn, pace=Pace(1.0, 0.4 + 0.01 * number, 0.1, 1.0, True)))
    assert len(told) == 1
    assert "Hide the 3-D view (Ctrl+0)" in told[0].remedy


@pytest.mark.parametrize("fault", ["webgl", "lost"])
def test_a_page_that_cannot_draw_says_what_to_do_and_offers_its_address(panel, web, fault):
    web.state["fault"] = fault
    panel._look_at_page()
    assert panel.said == PAGE_FAULT_TEXTS[fault]
    assert panel._address.text() == PAGE
    assert panel._browse.isVisible()
    assert panel.plain.isVisible()  # Qt draws the flight itself meanwhile
    web.state["fault"] = ""
    panel._again.click()
    assert web.went == [PAGE, PAGE]
    assert panel.said == "" and not panel.plain.isVisible()


def test_a_page_that_hangs_and_one_whose_process_ends_are_told(panel, web, clock):
    web.state = None
    panel._look_at_page()
    assert panel.said == ""
    clock[0] += PAGE_TIMEOUT_S + 1.0
    panel._look_at_page()
    assert panel.said == PAGE_FAULT_TEXTS["silent"]
    web.renderProcessTerminated.emit(None, 1)
    assert panel.said == PAGE_FAULT_TEXTS["ended"]


def test_a_picture_that_is_drawn_but_not_seen_is_told(panel, web, clock):
    web.is_seen = False
    panel._look_at_page()
    assert panel.said == ""
    clock[0] += PAGE_TIMEOUT_S + 1.0
    panel._look_at_page()
    assert panel.said == BLANK_VIEW_TEXT
    web.is_seen = True
    panel._look_at_page()
    assert panel.said == ""


def test_a_page_that_begins_looks_as_the_one_before_it_did(panel, web, actions):
    panel.look("follow")
    actions["trail_3d"].setChecked(False)
    web.ran.clear()
    panel._look_at_page()
    *first, background = web.ran
    assert first == [
        PAGE_STATE_SCRIPT,
        'window.workbench?.look("follow")',
        'window.workbench?.show("trail", false)',
        'window.workbench?.show("arrows", true)',
        'window.workbench?.show("lidar", true)',
    ]
    assert background.startswith("window.workbench?.background(...[[")
    panel.look("top")
    assert web.ran[-1] == 'window.workbench?.look("top")'


def orders_of(web, name):
    """What the script in the page was told by a name, as JSON."""
    head = f"window.workbench?.{name}("
    return [json.loads(f"[{each[len(head) : -1]}]") for each in web.ran if each.startswith(head)]


def test_a_log_is_flown_by_a_pale_drone_in_the_page(panel, web, workspace, qtbot, drawn):
    panel._look_at_page()
    web.ran.clear()
    workspace.scene.show_log(straight_log())
    vehicle = drawn.vehicle
    ((shape, places),) = orders_of(web, "log")
    assert shape == ["drake", "visualizer", vehicle.name, vehicle.base_link]
    assert places[-3:] == [2.0, 0.0, 1.0]
    for time in (0.25, 0.5, 0.75):  # as while it plays
        workspace.scene.replay(time)
    qtbot.waitUntil(lambda: len(orders_of(web, "replay")) == 2, timeout=5000)
    (pose,) = orders_of(web, "replay")[-1]
    assert pose == [*(1.0, 0.0, 0.0, 0.0), *(0.0, 1.0, 0.0, 0.0), *(0.0, 0.0, 1.0, 0.0)] + [
        *(1.5, 0.0, 1.0, 1.0)  # by columns, the newest time alone
    ]
    assert "it.mcap" in panel._log_line.text() and panel._log_line.isVisible()
    panel.reload()  # a page that begins anew has it, too
    web.ran.clear()
    panel._look_at_page()
    assert len(orders_of(web, "log")) == 1
    workspace.scene.show_log(None)
    assert orders_of(web, "replay")[-1] == [None]
    assert not panel._log_line.isVisible()


def test_a_log_without_a_position_says_so(panel, web, workspace):
    log = straight_log()
    workspace.scene.show_log(dataclasses.replace(log, signals={}))
    assert "it.mcap has no position" in panel._log_line.text()
    assert orders_of(web, "log") == []


def test_a_predicted_way_goes_to_all_pages_of_the_flight(panel, web, workspace, monkeypatch, drawn):
    given = []

    monkeypatch.setattr(workspace.flight, "_live", object())
    monkeypatch.setattr(workspace.flight, "do", given.append)
    way = np.zeros((3, 3))
    workspace.scene.foreseen.emit(4.0, way)
    (order,) = given
    assert isinstance(order, ShowPrediction)
    assert (order.ends, order.p_WB) == (4.0, way)
    undrawn = dataclasses.replace(drawn, url="")
    monkeypatch.setattr(workspace.flight, "_view", undrawn)
    workspace.scene.foreseen.emit(4.0, way)
    assert len(given) == 1
    monkeypatch.setattr(workspace.flight, "_live", None)


def test_while_it_is_hidden_there_is_no_page(panel, web, qtbot):
    panel.hide()
    assert web.went[-1] == BLANK_PAGE_URL
    panel.look("top")
    assert web.ran == []
    panel.show()
    qtbot.waitUntil(lambda: web.went[-1] == PAGE, timeout=5000)


def test_keys_go_to_the_window_and_not_to_the_page(panel, web, qtbot):
    heard, window = [], QWidget()
    qtbot.addWidget(window)
    line = QLineEdit()
    window.keyPressEvent = lambda event: heard.append(event.key())
    layout = QVBoxLayout(window)
    layout.addWidget(line)
    layout.addWidget(panel)
    page = QLineEdit(web)
    web.setFocusProxy(page)
    panel._look_at_page()
    window.show()
    line.setFocus()
    QTest.mouseClick(page, Qt.MouseButton.LeftButton)
    assert not page.hasFocus()
    page.setFocus()
    QTest.keyClick(page, Qt.Key.Key_H)
    assert page.text() == ""
    assert heard == [Qt.Key.Key_H]
    panel.setParent(None)


@pytest.mark.parametrize(
    ("given", "is_root", "wanted"),
    [
        ("", False, f"--ignore-gpu-blocklist {SMALL_HEAP_FLAG}"),
        ("", True, f"--ignore-gpu-blocklist {SMALL_HEAP_FLAG} --no-sandbox"),
        (
            "--no-sandbox --mine",
            True,
            f"--no-sandbox --mine --ignore-gpu-blocklist {SMALL_HEAP_FLAG}",
        ),
        ("--js-flags=--mine", False, "--js-flags=--mine --ignore-gpu-blocklist"),
    ],
)
def test_chromium_gets_its_flags_beside_those_of_the_user(given, is_root, wanted):
    environment = {CHROMIUM_FLAGS_VARIABLE: given} if given else {}
    prepare_web_engine(environment, is_root=is_root, draws=True)
    assert environment == {CHROMIUM_FLAGS_VARIABLE: wanted}


def test_without_a_graphics_processor_no_buffers_are_shared_with_one(tmp_path):
    node = tmp_path / "renderD128"
    assert not can_use_gpu([node])
    node.touch()
    assert can_use_gpu([node])
    for given, wanted in (({}, "0"), ({FORCE_GBM_VARIABLE: "1"}, "1")):
        prepare_web_engine(given, is_root=False, draws=False)
        assert given[FORCE_GBM_VARIABLE] == wanted


def test_a_missing_package_and_a_missing_library_are_sentences(monkeypatch):
    monkeypatch.setenv(CHROMIUM_FLAGS_VARIABLE, "")
    monkeypatch.setattr(web_engine, "WEB_WIDGETS_MODULE", "PyQt6.QtNoEngine")
    with pytest.raises(WorkbenchError, match="pip install PyQt6-WebEngine"):
        load_web_view()
    said = missing_library("libnss3.so: cannot open shared object file: No such file")
    assert "the system library libnss3.so, which is missing" in said
    assert missing_library("odd") == "The 3-D view cannot be loaded: odd."
