"""Profiles in files and on the clipboard."""

from workbench.gains.profiles import load_gains

NAME = "kp_velocity_x"


def test_what_is_copied_is_a_gain_file_of_what_flies(bench, tmp_path):
    bench.know()
    bench.desk.propose(NAME, 4.5)
    path = tmp_path / "copied.yaml"
    path.write_text(bench.desk.as_yaml())
    copied = load_gains(path)
    assert copied.vehicle == "dh_drone"
    assert copied.gains[NAME] == 4.5
    assert set(copied.gains) == set(bench.desk.profile_names)


def test_what_is_saved_is_what_flies(bench, workspace, qtbot, tmp_path):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.know()
    bench.desk.propose(NAME, 4.5)
    bench.desk.apply()
    bench.desk.propose(NAME, 9.0)
    path = tmp_path / "brisk.yaml"
    with qtbot.waitSignal(bench.desk.profiles.named):
        bench.desk.save(path, "tuned in flight")
    saved = load_gains(path)
    assert (saved.gains[NAME], saved.origin) == (4.5, "tuned in flight")
    assert bench.desk.profiles.name == "brisk"


def test_a_file_that_cannot_be_written_is_told(bench, qtbot, tmp_path):
    bench.desk.save(tmp_path / "nowhere" / "brisk.yaml", "tuned in flight")
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert "cannot be written" in bench.told[-1].what


def test_a_loaded_profile_flies_only_what_is_taken(bench, gain_file, qtbot):
    bench.know()
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.load(gain_file)
    offer = offered.args[0]
    assert [change.name for change in offer.changes] == [NAME, "kp_roll"]
    assert bench.flight.given == []
    bench.desk.profiles.take(["kp_roll"])
    bench.analysis.judge(stable=True) if bench.desk.unflown else None
    assert bench.flight.given == [("kp_roll", 200.0)]
    bench.desk.undo()
    assert bench.desk.flown["kp_roll"] == 150.0


def test_a_wrong_file_is_told_with_its_line(bench, tmp_path, qtbot):
    path = tmp_path / "wrong.yaml"
    path.write_text("gains:\n  kp_velocity_x: 99\n")
    bench.desk.load(path)
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert "wrong.yaml:2" in bench.told[-1].what


def test_lines_of_the_clipboard_are_a_profile(bench, qtbot):
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.profiles.paste("kp_velocity_x: 4.5 1/s\nkp_roll: 150 1/s^2\n")
    assert [(change.name, change.b) for change in offered.args[0].changes] == [(NAME, 4.5)]


def test_what_the_clipboard_has_wrong_is_told(bench, qtbot):
    bench.desk.profiles.paste("gains:\n  kp_velocity_x: nonsense\n")
    qtbot.waitUntil(lambda: len(bench.told) > 0, timeout=10000)
    assert bench.told[-1].what.startswith("the clipboard:2")


def test_a_model_without_gains_offers_those_of_the_start(bench, qtbot):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    with qtbot.waitSignal(bench.desk.profiles.offered) as offered:
        bench.desk.profiles.load_own()
    assert [(change.name, change.b) for change in offered.args[0].changes] == [(NAME, 3.0)]
