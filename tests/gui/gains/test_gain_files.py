"""Gain files on disk and on the clipboard."""

from dataclasses import replace

from workbench.gains.gains import load_gains
from workbench.scenario.scenario import Action, Scenario

NAME = "kp_velocity_x"


def test_what_is_copied_is_a_gain_file_of_what_flies(rig, tmp_path):
    rig.know()
    rig.editor.propose(NAME, 4.5)
    path = tmp_path / "copied.yaml"
    path.write_text(rig.gain_files.as_yaml())
    copied = load_gains(path)
    assert copied.vehicle == "dh_drone"
    assert copied.gains[NAME] == 4.5
    assert set(copied.gains) == set(rig.editor.saved_names)


def test_what_is_saved_is_what_flies(rig, workspace, qtbot, tmp_path):
    workspace.preferences.set("apply_gains", "on Enter")
    rig.know()
    rig.editor.propose(NAME, 4.5)
    rig.editor.apply()
    rig.editor.propose(NAME, 9.0)
    path = tmp_path / "brisk.yaml"
    with qtbot.waitSignal(rig.gain_files.named):
        rig.gain_files.save(path)
    saved = load_gains(path)
    assert saved.gains[NAME] == 4.5
    assert saved.origin == "tuned in flight, from Start of the flight"
    assert rig.gain_files.name == "brisk"


def test_a_file_that_cannot_be_written_is_told(rig, qtbot, tmp_path):
    rig.gain_files.save(tmp_path / "nowhere" / "brisk.yaml")
    qtbot.waitUntil(lambda: len(rig.told) > 0, timeout=10000)
    assert "cannot be written" in rig.told[-1].what


def test_a_loaded_gain_file_flies_only_what_is_taken(rig, gain_file, qtbot):
    rig.know()
    with qtbot.waitSignal(rig.gain_files.diff_changed) as compared:
        rig.gain_files.load(gain_file)
    assert [change.name for change in compared.args[0].changes] == [NAME, "kp_roll"]
    assert rig.flight.given == []
    rig.gain_files.take(["kp_roll"])
    rig.analysis.judge(stable=True) if rig.editor.unflown else None
    assert rig.flight.given == [("kp_roll", 200.0)]
    rig.editor.undo()
    assert rig.editor.flown["kp_roll"] == 150.0


def test_a_wrong_file_is_told_with_its_line(rig, tmp_path, qtbot):
    path = tmp_path / "wrong.yaml"
    path.write_text("gains:\n  kp_velocity_x: 99\n")
    rig.gain_files.load(path)
    qtbot.waitUntil(lambda: len(rig.told) > 0, timeout=10000)
    assert "wrong.yaml:2" in rig.told[-1].what


def test_lines_of_the_clipboard_are_a_gain_file(rig, qtbot):
    with qtbot.waitSignal(rig.gain_files.diff_changed) as compared:
        rig.gain_files.paste("kp_velocity_x: 4.5 1/s\nkp_roll: 150 1/s^2\n")
    assert [(change.name, change.b) for change in compared.args[0].changes] == [(NAME, 4.5)]


def test_what_the_clipboard_has_wrong_is_told(rig, qtbot):
    rig.gain_files.paste("gains:\n  kp_velocity_x: nonsense\n")
    qtbot.waitUntil(lambda: len(rig.told) > 0, timeout=10000)
    assert rig.told[-1].what.startswith("the clipboard:2")


def test_a_model_without_gains_offers_those_of_the_start(rig, qtbot):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    with qtbot.waitSignal(rig.gain_files.diff_changed) as compared:
        rig.gain_files.load_own()
    assert [(change.name, change.b) for change in compared.args[0].changes] == [(NAME, 3.0)]


def test_what_a_script_sets_is_not_lost(rig, new_view):
    """It is in the scenario; what is tuned beside it, or after it, is in no file."""
    scenario = Scenario(script=[Action(at=1.0, set={NAME: 4.1})])
    rig.editor.begin(replace(new_view(), scenario=scenario))
    rig.know()
    rig.flight.publish(1.0, **{NAME: 4.1})
    assert rig.editor.tried == (NAME,)
    assert rig.gain_files.unsaved() == ""
    rig.editor.keep()
    assert rig.gain_files.unsaved() == ""
    rig.editor.propose("kp_roll", 200.0)
    assert "The gains that fly are in no file" in rig.gain_files.unsaved()
    rig.editor.undo()
    rig.editor.propose(NAME, 4.2)
    assert "The gains that fly are in no file" in rig.gain_files.unsaved()


def test_what_a_script_sets_after_a_gain_file_is_not_lost(rig, new_view, gain_file, qtbot):
    scenario = Scenario(script=[Action(at=1.0, set={NAME: 4.1})])
    rig.editor.begin(replace(new_view(), scenario=scenario))
    rig.know()
    with qtbot.waitSignal(rig.gain_files.diff_changed):
        rig.gain_files.load(gain_file)
    rig.gain_files.take([NAME, "kp_roll"])
    assert rig.gain_files.unsaved() == ""
    rig.flight.publish(2.0, **{NAME: 4.1})
    assert rig.editor.flown[NAME] == 4.1 and rig.gain_files.unsaved() == ""
    rig.editor.propose("kp_roll", 180.0)
    assert "The gains that fly are in no file" in rig.gain_files.unsaved()
