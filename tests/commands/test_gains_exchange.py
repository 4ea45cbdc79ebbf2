"""`workbench gains import`, `export` and `translate`."""

import pytest

from workbench.design.judge.loop_judgement import hover_margins
from workbench.design.linear.operating_point import HOLDING
from workbench.design.linear.study import LinearStudy
from workbench.gains.gains import load_gains
from workbench.scenario.scenario import Scenario

PARAMS = """# Onboard parameters for Vehicle 1
#
# Version: 1.16.0
1\t1\tBAT1_N_CELLS\t4\t6
1\t1\tMC_ROLLRATE_P\t0.119999997317790985\t9
1\t1\tMC_ROLLRATE_K\t1\t9
1\t1\tMPC_LAND_SPEED\t0.699999988079071045\t9
"""
BETAFLIGHT = "# Betaflight / STM32F405 (S405) 4.4.3 x / y (z) MSP API: 1.45\n"
UNSAFE = PARAMS.replace("0.119999997317790985", "-0.12")


@pytest.fixture
def vehicle(write):
    return write("vehicle.params", PARAMS)


def test_import_says_what_changes_in_the_firmwares_words(run, vehicle):
    lines = run("gains", "import", vehicle, "--no-margins").out.splitlines()
    assert lines[0].endswith("px4 1.16.0, law px4, vehicle dh_drone")
    rows = [" ".join(line.split()) for line in lines[2:6]]
    assert rows == [
        "MC_ROLL_P 4 6.5 1/s +62.5 % attitude P gain, roll (default)",
        "MC_PITCH_P 4 6.5 1/s +62.5 % attitude P gain, pitch (default)",
        "MC_ROLLRATE_P 0.15 0.12 s/rad -20.0 % roll rate P gain",
        "IMU_DGYRO_CUTOFF 20 30 Hz +50.0 % D low-pass cutoff (default)",
    ]
    assert lines[6] == "4 of 5 gains differ"
    assert lines[7] == "lines: 2 flown, 1 not flown, 1 unknown; --json accounts for each"
    assert lines[8] == "not imported, and without effect here: MPC_LAND_SPEED"
    assert lines[9] == "on by default in 1.16, and not simulated: MPC_VELD_LP 5"
    assert lines[10] == "note: line 4: of other parts, or unknown: BAT1_N_CELLS 4"


def test_import_tells_margins_before_and_after(run, vehicle):
    """Those of `hover_margins`, which are held against python-control elsewhere."""
    said = run("gains", "import", vehicle, "--json").json
    after = {row["name"]: row["b"] for row in said["gains"] if row["a"] != row["b"]}
    assert after == {
        "MC_ROLL_P": 6.5,
        "MC_PITCH_P": 6.5,
        "MC_ROLLRATE_P": 0.12,
        "IMU_DGYRO_CUTOFF": 30.0,
    }
    study = LinearStudy(Scenario(controller="px4"))
    loops = {row["loop"]: row for row in said["margins"]}
    for gains, key in (({}, "before"), (after, "after")):
        for loop, margins in hover_margins(study.sampled(HOLDING, gains)).items():
            found = loops[loop][key]
            assert found["phase_margin"] == pytest.approx(margins.phase_margin, rel=1e-9)


def test_import_keeps_gains_in_a_file(run, vehicle, tmp_path):
    kept = tmp_path / "mine.yaml"
    assert run("gains", "import", vehicle, "--no-margins", "--save", kept).code == 0
    saved = load_gains(kept)
    assert (saved.controller, saved.gains["MC_ROLLRATE_P"]) == ("px4", 0.12)
    assert saved.origin == "vehicle.params, px4 1.16.0"


def test_what_is_unsafe_is_named_and_nothing_is_kept(run, write, tmp_path):
    kept = tmp_path / "mine.yaml"
    path = write("unsafe.params", UNSAFE)
    done = run("gains", "import", path, "--no-margins", "--save", kept)
    assert done.code == 2
    assert "MC_ROLLRATE_P is negative: this would reverse" in done.err
    assert not kept.exists()


def test_export_changes_nothing_but_gains(run, vehicle):
    words = ("--for", "px4", "--set", "MC_ROLLRATE_P=0.18", "--no-margins")
    assert run("gains", "export", vehicle, *words, "--preview").code == 0
    assert vehicle.read_text() == PARAMS
    done = run("gains", "export", vehicle, *words)
    assert done.code == 0
    assert "wrote" in done.err
    assert vehicle.read_text() == PARAMS.replace("0.119999997317790985", "0.180000007152557373")


def test_export_writes_a_new_file_for_an_older_firmware(run, tmp_path):
    path = tmp_path / "new.param"
    words = ("--for", "ardupilot", "--firmware", "4.6", "--no-margins")
    assert run("gains", "export", path, *words).code == 0
    assert "PSC_ACCZ_P,0.5\n" in path.read_text()
    assert run("gains", "import", path, "--no-margins").out.splitlines()[1] == (
        "0 of 71 gains differ"
    )


def test_export_refuses_gains_of_another_law(run, write, tmp_path):
    pd = write("pd.yaml", "gains: {kp_roll: 200}\n")
    done = run("gains", "export", tmp_path / "x.params", "--for", "px4", "--gains", pd)
    assert done.code == 2
    assert "`workbench gains translate pd --to px4`" in done.err
    assert not (tmp_path / "x.params").exists()


def test_translate_says_gains_loops_and_what_is_not_exact(run, tmp_path):
    kept = tmp_path / "px4.yaml"
    said = run("gains", "translate", "pd", "--to", "px4", "--save", kept, "--json").json
    gains = {row["name"]: row for row in said["gains"]}
    assert gains["MC_ROLL_P"]["value"] == pytest.approx(225.0 / 27.0)  # kp over kd
    assert gains["MC_ROLL_P"]["said"] == "exact"
    assert {row["channel"] for row in said["loops"]["gains_alone"]} == {
        "z",
        "roll",
        "pitch",
        "yaw",
    }
    assert all(row["largest"] < 0.01 for row in said["loops"]["gains_alone"])
    assert "MC_YAW_P is 0: nothing corrects the heading" in said["remarks"]
    assert load_gains(kept).gains["MC_ROLL_P"] == gains["MC_ROLL_P"]["value"]
    text = run("gains", "translate", kept, "--to", "pid").out
    assert text.startswith("dh_drone: gains of px4, translated to pid")


def test_wrong_words_end_in_a_sentence(run, write, tmp_path, case):
    params = write("vehicle.params", PARAMS)
    for words, said in (
        (("import", tmp_path / "gone.params"), "no such file"),
        (("import", params, "--for", "betaflight"), "sets none of the"),
        (("import", params, "--save", "x.txt"), "ends in .yaml"),
        (("import", params, "--controller", "pd"), "is not one of its laws"),
        (("translate", "pd", "--to", "lqi"), "lqi has weights"),
        (("translate", "pd", "--to", "pd"), "name another law"),
        (("translate", "pd", "--to", "px4", "--controller", "pid"), "leave --controller out"),
        (("export", tmp_path, "--for", "px4"), "is a folder"),
    ):
        with case(words):
            done = run("gains", *words)
            assert done.code == 2
            assert said in done.err
            assert "Traceback" not in done.err


def test_gains_that_would_not_fly_are_written_by_force_alone(run, tmp_path):
    path, words = tmp_path / "x.params", ("--for", "px4", "--set", "MC_YAW_P=0", "--no-margins")
    done = run("gains", "export", path, *words)
    assert done.code == 2
    assert "would not fly: MC_YAW_P is 0: nothing corrects the heading" in done.err
    assert not path.exists()
    assert run("gains", "export", path, *words, "--preview").code == 0
    assert not path.exists()
    assert run("gains", "export", path, *words, "--force").code == 0
    assert "MC_YAW_P\t0\t9" in path.read_text()


def test_json_has_every_line_and_the_place_of_each_remark(run, write):
    lines = "aux 0 0 0 900 1200 0 0\nset p_roll = 50\nset dyn_notch_count = 3\nset d_min_gain = 2\n"
    path = write("x.txt", BETAFLIGHT + lines)
    said = run("gains", "import", path, "--no-margins", "--json").json
    assert [(each["line"], each["part"]) for each in said["lines"]] == [
        (2, "not flown"),
        (3, "flown"),
        (4, "not flown"),
        (5, "unknown"),
    ]
    assert said["lines"][2]["why"] == "not simulated"
    assert said["account"]["not flown"] == {"count": 2, "names": ["dyn_notch_count"]}
    details = {each["text"].partition(":")[0]: each for each in said["remark_details"]}
    refused = details["unknown to betaflight 4.4, which refuses the line"]
    assert (refused["place"], refused["count"]) == (f"{path}:5", 1)
    assert said["acting"] == [{"name": "dyn_notch_count", "value": "3", "line": 4}]
