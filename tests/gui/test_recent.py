"""Recent files, and what a file is."""

import pytest
from PyQt6.QtCore import QSettings

from workbench.common.errors import WorkbenchError
from workbench.common.resources import (
    find_model,
    find_scenario,
    find_world,
    list_scenarios,
    list_worlds,
)
from workbench.gui.opener import kind_of
from workbench.gui.recent_files import MAX_RECENT_FILES, RECENT_FILES_KEY, FileKind, RecentFiles


@pytest.fixture
def store(tmp_path):
    return QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)


@pytest.fixture
def file(tmp_path):
    def make(name, text=""):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    return make


def test_the_newest_comes_first_and_none_twice(store, file):
    recent = RecentFiles(store)
    one, two = file("one.yaml"), file("two.mcap")
    for kind, path in (
        (FileKind.SCENARIO, one),
        (FileKind.LOG, two),
        (FileKind.SCENARIO, one),
    ):
        recent.add(kind, str(path))
    assert recent.files() == (
        (FileKind.SCENARIO, str(one)),
        (FileKind.LOG, str(two)),
    )


def test_they_are_there_at_the_next_start(store, file, tmp_path):
    path = file("a file, with: strange = signs.yaml")
    RecentFiles(store).add(FileKind.WORLD, str(path))
    store.sync()
    again = QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)
    assert RecentFiles(again).files() == ((FileKind.WORLD, str(path)),)


def test_what_is_gone_vanishes(store, file):
    recent = RecentFiles(store)
    path = file("here.yaml")
    recent.add(FileKind.SCENARIO, str(path))
    path.unlink()
    assert recent.files() == ()


def test_only_so_many_are_kept(store, file):
    recent = RecentFiles(store)
    for number in range(MAX_RECENT_FILES + 3):
        recent.add(FileKind.LOG, str(file(f"{number}.mcap")))
    assert len(recent.files()) == MAX_RECENT_FILES
    assert recent.files()[0][1].endswith(f"{MAX_RECENT_FILES + 2}.mcap")


@pytest.mark.parametrize("kept", ["nonsense", ["x", 3, "planet:/tmp"], 7, None])
def test_settings_that_make_no_sense_are_passed_over(store, kept):
    store.setValue(RECENT_FILES_KEY, kept)
    assert RecentFiles(store).files() == ()


def test_shipped_files_are_known_for_what_they_are():
    assert {kind_of(find_scenario(name)) for name in list_scenarios()} == {FileKind.SCENARIO}
    assert {kind_of(find_world(name)) for name in list_worlds()} == {FileKind.WORLD}
    assert kind_of(find_model("dh_drone")) is FileKind.MODEL


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("a.SDF", "<sdf><model name='x'/></sdf>", FileKind.MODEL),
        ("b.sdf", "<sdf version='1.6'><world name='w'>", FileKind.WORLD),
        ("c.world", "", FileKind.WORLD),
        ("d.urdf", "", FileKind.MODEL),
        ("x2.xml", "<mujoco/>", FileKind.MODEL),
        ("e.mcap", "\x89MCAP0", FileKind.LOG),
        ("f.yml", "title: x\n", FileKind.SCENARIO),
        ("g.layout.yaml", "version: 1\ncharts: []\n", FileKind.LAYOUT),
        ("h.workbench.yaml", "title: x\ncases:\n", FileKind.SPEC),
    ],
)
def test_a_file_is_known_by_its_name_and_beginning(file, name, text, kind):
    assert kind_of(file(name, text)) is kind


def test_a_gazebo_model_s_folder_is_a_model(file):
    assert kind_of(file("x500/model.config").parent) is FileKind.MODEL


def test_anything_else_is_refused_in_a_sentence(file, tmp_path):
    with pytest.raises(WorkbenchError, match=r"notes\.txt cannot be opened: drop a scenario"):
        kind_of(file("notes.txt"))
    with pytest.raises(WorkbenchError, match="no such file"):
        kind_of(tmp_path / "gone.yaml")
