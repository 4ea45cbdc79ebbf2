"""Pictures and logs."""

import dataclasses

from workbench.gui.recorder import log_name, size_text
from workbench.gui.saved_files import save_beside_logs
from workbench.live.messages import NetworkView


def test_a_screenshot_goes_to_the_folder_and_is_told(opened, qtbot, told, tmp_path):
    window = opened()
    window.actions_by_name["screenshot"].trigger()
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    (picture,) = (tmp_path / "logs").iterdir()
    assert told[0].what == f"Saved {picture}"
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_folder_that_cannot_be_written_is_a_notice(opened, qtbot, told, workspace, tmp_path):
    (tmp_path / "file").write_text("")
    workspace.preferences.set("log_folder", str(tmp_path / "file"))
    window = opened()
    window.actions_by_name["screenshot"].trigger()
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    assert "was not saved" in told[0].what
    assert "Settings" in told[0].remedy
    window.recorder.toggle()
    assert "the folder for logs cannot be made" in told[1].what


def test_a_picture_that_qt_does_not_write_is_a_notice(workspace, qtbot, told, tmp_path):
    workspace.preferences.set("log_folder", str(tmp_path))
    save_beside_logs(workspace, "chart.png", lambda path: 0)
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    why = "the disk is full, or the folder is not writable"
    assert told[0].what == f"{tmp_path / 'chart.png'} was not saved: {why}"


def test_a_log_that_ends_by_itself_is_told_and_the_flight_goes_on(opened, show, canned, told):
    window = opened()
    view = canned.views[0]
    show(dataclasses.replace(view, network=NetworkView(log="/tmp/a.mcap")))
    assert window.recorder.is_recording
    assert window.actions_by_name["record"].isChecked()
    show(dataclasses.replace(view, network=NetworkView(log_said="the disk is full")))
    assert told[0].what == "recording has ended: the disk is full"
    assert "Choose another folder" in told[0].remedy
    assert not window.actions_by_name["record"].isChecked()


def test_a_log_that_ends_with_its_flight_is_kept_and_told(opened, show, canned, told, tmp_path):
    """A reset goes on in the next file; a flight that is over, or dead, records no more."""
    window = opened()
    a, b = tmp_path / "a.mcap", tmp_path / "a-2.mcap"
    a.touch()
    b.touch()
    first = dataclasses.replace(canned.views[0], network=NetworkView(log=str(a)))
    second = dataclasses.replace(first, network=NetworkView(log=str(b)))
    for view in (first, second, second.ended("the flight's process was killed")):
        show(view)
    assert not window.recorder.is_recording
    assert not window.actions_by_name["record"].isChecked()
    assert [each.what for each in told] == [f"recorded {a}", f"recorded {b}"]


def test_log_names_suit_file_systems():
    from datetime import datetime

    noon = datetime(2026, 3, 4, 12, 30, 5)
    assert log_name("dh_drone", noon) == "dh_drone-20260304-123005.mcap"
    assert log_name("a/b: ü", noon) == "a_b_-20260304-123005.mcap"
    assert [size_text(size) for size in (0, 12_300, 4_560_000, 7_890_000_000)] == [
        "0 kB",
        "12 kB",
        "4.6 MB",
        "7.89 GB",
    ]
