"""Preferences are kept, and what an editor made of the file does no harm."""

import pytest
from PyQt6.QtCore import QSettings

from tests.gui.conftest import INI
from workbench.common.errors import WorkbenchError
from workbench.gui.app import warn_of_lost_settings
from workbench.gui.preferences import PREFERENCES, Preferences


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "kept.ini")


def opened(path):
    return Preferences(QSettings(path, QSettings.Format.IniFormat))


def test_a_value_is_there_in_the_next_program(path, qapp):
    first = opened(path)
    first.set("stick_expo", 0.55)
    first.set("draw_3d", False)
    first.set("theme", "dark")
    first.store.sync()
    again = opened(path)
    assert again.number("stick_expo") == 0.55
    assert again.switch("draw_3d") is False
    assert again.text("theme") == "dark"


def test_a_change_is_told_once(path, qtbot):
    preferences = opened(path)
    heard = []
    preferences.changed.connect(heard.append)
    preferences.set("stick_expo", 0.7)
    preferences.set("stick_expo", 0.7)
    preferences.reset("stick_expo")
    assert heard == ["stick_expo", "stick_expo"]
    assert preferences.number("stick_expo") == 0.3


@pytest.mark.parametrize(
    ("value", "said"), [(float("nan"), "give it a number"), (1.5, "0 .. 1"), (-0.1, "0 .. 1")]
)
def test_a_number_out_of_its_range_is_refused(path, qapp, value, said):
    with pytest.raises(WorkbenchError, match=said):
        opened(path).set("stick_expo", value)


def test_an_unknown_choice_is_refused(path, qapp):
    with pytest.raises(WorkbenchError, match="drak"):
        opened(path).set("theme", "drak")


@pytest.mark.parametrize(
    ("name", "kept"), [("stick_expo", "much"), ("stick_expo", "7"), ("theme", "pink")]
)
def test_nonsense_in_the_file_is_the_default(path, qapp, name, kept):
    QSettings(path, QSettings.Format.IniFormat).setValue(f"preferences/{name}", kept)
    preferences = opened(path)
    row = next(row for row in PREFERENCES if row.name == name)
    found = preferences.text(name) if isinstance(row.default, str) else preferences.number(name)
    assert found == row.default


def test_defaults_may_be_kept_and_names_are_unique():
    assert len({row.name for row in PREFERENCES}) == len(PREFERENCES)
    for row in PREFERENCES:
        assert row.valid(row.default) == row.default
        assert row.help.endswith(".")


def test_a_store_that_cannot_be_written_is_told_once_the_window_is_there(workspace, told, qtbot):
    """A home without a right to write: everything set was lost without a word."""
    warn_of_lost_settings(workspace)
    assert told == []
    workspace.preferences.store = QSettings("/proc/settings/workbench.ini", INI)
    warn_of_lost_settings(workspace)
    assert "/proc/settings/workbench.ini cannot be written" in told[0].what
    assert "XDG_CONFIG_HOME" in told[0].remedy
