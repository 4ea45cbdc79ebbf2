"""`workbench gains import` and `export`, which also translate gains of one law to another."""

import dataclasses

import pytest

from workbench.design.judge.loop_judgement import hover_margins
from workbench.design.linear.operating_point import HOLDING_POINT
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.translation import translate
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
        for loop, margins in hover_margins(study.sampled(HOLDING_POINT, gains)).items():
            found = loops[loop][key]
            assert found["phase_margin_deg"] == pytest.approx(margins.phase_margin_deg, rel=1e-9)


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
    path = tmp_path / "new" / "new.param"
    words = ("--for", "ardupilot", "--firmware", "4.6", "--no-margins")
    assert run("gains", "export", path, *words).code == 0
    assert "PSC_ACCZ_P,0.5\n" in path.read_text()
    assert run("gains", "import", path, "--no-margins").out.splitlines()[1] == (
        "0 of 71 gains differ"
    )


def function_of(old, new, **settings):
    """Return what the function `translate` makes of a law's gains on the shipped drone."""
    studies = [LinearStudy(Scenario(controller=law)) for law in (old, new)]
    values = [dict(study.gains) for study in studies]
    return translate(*studies, values[0] | settings, values[1])


def assert_translated(said, found, old, new):
    """The command has every number and remark of the function, but for rounding."""
    assert (said["from"], said["to"]) == (old, new)
    for row, each in zip(said["gains"], found.gains, strict=True):
        assert row.pop("value") == pytest.approx(each.value, rel=1e-12)
        assert row == {"name": each.name, "unit": each.unit, "said": each.said}
    assert said["lost"] == [dataclasses.asdict(each) for each in found.lost]
    assert said["remarks"] == list(found.remarks)
    assert {row["channel"] for row in said["loops"]["flown"]} == {"z", "roll", "pitch", "yaw"}


def test_export_translates_gains_of_another_law(run, write, tmp_path, case):
    path = tmp_path / "x.params"
    gains = write("pd.yaml", "gains: {kp_roll: 200}\n")
    for words, settings in (
        (("--gains", gains), {"kp_roll": 200.0}),
        (("--gains", gains, "--controller", "px4"), {"kp_roll": 200.0}),
        (("--controller", "pd", "--set", "kp_roll=180"), {"kp_roll": 180.0}),
    ):
        with case(words):
            command = ("gains", "export", path, "--for", "px4", *words, "--no-margins")
            said = run(*command, "--preview", "--json").json
            found = function_of("pd", "px4", **settings)
            assert_translated(said["translation"], found, "pd", "px4")
            assert {row["name"]: row["b"] for row in said["gains"]}["MC_ROLL_P"] == pytest.approx(
                settings["kp_roll"] / 27.0  # kp over kd
            )
            assert not path.exists()
            refused = run(*command)
            assert refused.code == 2
            assert refused.out.startswith("dh_drone: gains of pd, translated to px4\n")
            assert "would not fly: " in refused.err
    mended = [f"MC_{axis}RATE_I=0.1" for axis in ("ROLL", "PITCH", "YAW")]
    mended += ["MC_YAW_P=2.8", "MPC_XY_VEL_I_ACC=0.4", "MPC_Z_VEL_I_ACC=2", "kp_roll=180"]
    more = [word for each in mended for word in ("--set", each)]
    words = ("--for", "px4", "--controller", "pd", *more, "--no-margins")
    assert run("gains", "export", path, *words).code == 0
    written = path.read_text()
    assert "\tMC_YAW_P\t2.79999" in written
    assert "\tMC_ROLL_P\t6.66666" in written


def test_export_of_the_firmwares_own_law_translates_nothing(run, write, tmp_path):
    gains = write("px4.yaml", "controller: px4\ngains: {MC_ROLL_P: 5}\n")
    words = ("--for", "px4", "--gains", gains, "--no-margins", "--json")
    said = run("gains", "export", tmp_path / "x.params", *words)
    assert (said.code, said.json["translation"]) == (0, None)
    words = ("--for", "crazyflie", "--controller", "mellinger", "--preview", "--no-margins")
    assert "translated" not in run("gains", "export", tmp_path / "x.yaml", *words).out


def test_import_translates_to_another_law(run, vehicle, tmp_path):
    kept = tmp_path / "pid.yaml"
    words = ("--controller", "pid", "--save", kept, "--no-margins")
    said = run("gains", "import", vehicle, *words, "--json").json
    assert (said["controller"], said["files"]) == ("px4", [str(kept)])
    found = function_of("px4", "pid", **{row["name"]: row["b"] for row in said["gains"]})
    assert_translated(said["translation"], found, "px4", "pid")
    saved = load_gains(kept)
    assert saved.controller == "pid"
    assert saved.origin == "vehicle.params, px4 1.16.0, translated from px4 for dh_drone"
    assert saved.gains["kp_rate"] == pytest.approx(found.values["kp_rate"], rel=1e-12)
    out = run("gains", "import", vehicle, *words).out
    assert "4 of 5 gains differ" in out
    assert "\ndh_drone: gains of px4, translated to pid\n" in out


def test_import_translates_a_gain_file(run, write, tmp_path):
    kept = tmp_path / "px4.yaml"
    gains = write("pd.yaml", "gains: {kp_roll: 225}\n")
    words = ("gains", "import", gains, "--controller", "px4", "--save", kept)
    said = run(*words, "--json").json["translation"]
    by_name = {row["name"]: dict(row) for row in said["gains"]}
    assert_translated(said, function_of("pd", "px4", kp_roll=225.0), "pd", "px4")
    assert by_name["MC_ROLL_P"]["value"] == pytest.approx(225.0 / 27.0)  # kp over kd
    assert by_name["MC_ROLL_P"]["said"] == "exact"
    assert all(row["largest"] < 0.01 for row in said["loops"]["gains_alone"])
    assert "MC_YAW_P is 0: nothing corrects the heading" in said["remarks"]
    saved = load_gains(kept)
    assert saved.gains["MC_ROLL_P"] == by_name["MC_ROLL_P"]["value"]
    assert saved.origin == "translated from pd for dh_drone"
    out = run(*words, "--set", "MC_YAW_P=2.8").out
    assert out.endswith("set in place of what is translated: MC_YAW_P 2.8\n")
    assert load_gains(kept).gains["MC_YAW_P"] == 2.8
    text = run("gains", "import", kept, "--controller", "pid").out
    assert text.startswith("dh_drone: gains of px4, translated to pid")


def test_wrong_words_end_in_a_sentence(run, write, tmp_path, case):
    params = write("vehicle.params", PARAMS)
    gains = write("pd.yaml", "gains: {kp_roll: 225}\n")
    for words, said in (
        (("import", tmp_path / "gone.params"), "no such file"),
        (("import", params, "--for", "betaflight"), "sets none of the"),
        (("import", params, "--save", "x.txt"), "ends in .yaml"),
        (("import", params, "--controller", "lqi"), "lqi has weights"),
        (("import", gains), "is a gain file of pd already: name the law"),
        (("import", gains, "--controller", "pd"), "is a gain file of pd already"),
        (("import", gains, "--controller", "lqi"), "lqi has weights"),
        (("import", gains, "--controller", "px4", "--gains", gains), "leave --gains out"),
        (("import", gains, "--controller", "px4", "--profile", "1"), "leave --firmware, --profile"),
        (("import", gains, "--controller", "px4", "--set", "x=1"), "unknown parameter 'x'"),
        (("export", tmp_path / "x", "--for", "px4", "--controller", "lqi"), "lqi has weights"),
        (("translate", "pd", "--to", "px4"), "`workbench gains export FILE --for px4 --contr"),
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
