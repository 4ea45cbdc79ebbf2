"""The 3-D view, with a stand-in for the web engine."""

import dataclasses

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QDesktopServices
from PyQt6.QtWidgets import QWidget

from workbench.errors import WorkbenchError
from workbench.gui.view3d import view3d_panel, web_engine
from workbench.gui.view3d.view3d_panel import ENDED, NOT_DRAWN, WAITING, View3d
from workbench.gui.view3d.web_engine import FLAGS, load_web_view, missing_library, prepare
from workbench.live.messages import Pace, Phase

PAGE, OTHER = "http://localhost:7000", "http://localhost:7001"


class Web(QWidget):
    """A web view that notes where it was sent."""

    def __init__(self):
        super().__init__()
        self.setAcceptDrops(True)  # as the web engine does
        self.went = []

    def setUrl(self, url):
        self.went.append(url.toString())


def no_engine():
    raise WorkbenchError("The 3-D view needs PyQt6-WebEngine.")


@pytest.fixture
def drawn(canned):
    return dataclasses.replace(canned.views[0], url=PAGE)


@pytest.fixture
def loaded():
    return []


@pytest.fixture
def panel(qtbot, workspace, loaded):
    def load():
        loaded.append(Web())
        return lambda: loaded[-1]

    made = View3d(workspace, load)
    qtbot.addWidget(made)
    yield made
    made.close_view()


def test_before_the_flight_it_says_so_and_loads_nothing(panel, qtbot, loaded):
    panel.show()
    qtbot.waitExposed(panel)
    assert panel.said == WAITING
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
    assert panel.said == ENDED
    assert loaded[0].went[-1] == "about:blank"


def test_a_flight_that_is_not_drawn_says_how(panel, show, canned):
    panel.show()
    show(canned.views[0])
    assert panel.said == NOT_DRAWN


def test_without_the_engine_it_says_what_to_install_and_offers_the_browser(
    qtbot, workspace, show, drawn, monkeypatch, told
):
    opened = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: not opened.append(url.toString()))
    panel = View3d(workspace, no_engine)
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
    panel, show, drawn, qtbot, loaded, told, monkeypatch
):
    clock = [100.0]
    monkeypatch.setattr(view3d_panel.time, "monotonic", lambda: clock[0])
    panel.show()
    show(drawn)
    qtbot.waitUntil(lambda: bool(loaded), timeout=5000)
    for number in range(4):
        clock[0] += 3.0
        show(dataclasses.replace(drawn, pace=Pace(1.0, 0.4 + 0.01 * number, 0.1, 1.0, True)))
    assert len(told) == 1
    assert "Hide the 3-D view (Ctrl+0)" in told[0].remedy


@pytest.mark.parametrize(
    ("given", "is_root", "wanted"),
    [
        ("", False, "--ignore-gpu-blocklist"),
        ("", True, "--ignore-gpu-blocklist --no-sandbox"),
        ("--no-sandbox --mine", True, "--no-sandbox --mine --ignore-gpu-blocklist"),
    ],
)
def test_chromium_gets_its_flags_beside_those_of_the_user(given, is_root, wanted):
    environment = {FLAGS: given} if given else {}
    prepare(environment, is_root=is_root)
    assert environment[FLAGS] == wanted


def test_a_missing_package_and_a_missing_library_are_sentences(monkeypatch):
    monkeypatch.setenv(FLAGS, "")
    monkeypatch.setattr(web_engine, "MODULE", "PyQt6.QtNoEngine")
    with pytest.raises(WorkbenchError, match="pip install PyQt6-WebEngine"):
        load_web_view()
    said = missing_library("libnss3.so: cannot open shared object file: No such file")
    assert "the system library libnss3.so, which is missing" in said
    assert missing_library("odd") == "The 3-D view cannot be loaded: odd."
