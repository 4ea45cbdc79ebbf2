"""An estimator in a file of the user's own: flown as a shipped one, and linear as it should be."""

import inspect
import math
import pickle
from pathlib import Path

import numpy as np
import pytest

from workbench.analysis.subject import AnalysedVehicle
from workbench.common.errors import WorkbenchError
from workbench.design.judge.phase_budget import PhaseStudy
from workbench.design.linear.study import LinearStudy
from workbench.estimation import complementary
from workbench.estimation.estimators import find_estimator
from workbench.estimation.settings import ComplementarySettings
from workbench.gui.gains.gain_rows import controller_gains, gain_label, is_gain, loop_gains
from workbench.scenario.scenario import Action, Scenario, SensorsConfig
from workbench.scenario.scenario_check import check_scenario
from workbench.scenario.sensor_choice import choose_sensors
from workbench.session.session import Session

LAG = Path(__file__).parent / "lag.py"
TEXT = LAG.read_text(encoding="utf-8")
UPDATE = "def update(memory, z, settings, mounting, dt):\n"
LINE = TEXT[: TEXT.index(UPDATE)].count("\n") + 1
STATES = '[State("samples", "1"), State("spread", "m", 0.2)]'
WRONG = {
    "no Python": ((STATES, "[State("), ["was never closed: correct this line"]),
    "a module that is not there": (
        ("import numpy as np", "import no_such_module"),
        [":3: ModuleNotFoundError", "install what is missing"],
    ),
    "a name that is not to be had": (
        ("    GPS,\n", "    GPS,\n    GSP,\n"),
        [":5: ImportError", "import what workbench.estimators names"],
    ),
    "no update": (("def update(", "def updates("), ["has no update: write def update(memory, z"]),
    "other arguments": (
        (UPDATE, "def update(memory, z):\n"),
        [f":{LINE}: update takes (memory, z): let it take (memory, z, settings, mounting, dt)"],
    ),
    "a begin of other arguments": (
        ("def begin(state, mounting, drawn, known)", "def begin(state)"),
        ["begin is not a function of (state, mounting, drawn, known): write def begin("],
    ),
    "too small a memory": (
        ("[0.0, 0.2]])", "[0.0]])"),
        ["begin returns 17: let it be an array of 18 numbers: 16 of the nominal state, and one"],
    ),
    "a place beyond the memory": (
        ("SPREAD = NOMINAL, NOMINAL + 1", "SPREAD = NOMINAL, NOMINAL + 2"),
        ["IndexError: index 18 is out of bounds"],
    ),
    "a covariance of another size": (
        ("np.eye(ERRORS)", "np.eye(9)"),
        ["covariance returns 9x9: let it be an array of 15 x 15 numbers"],
    ),
    "NaN": (
        ("memory[i] = x[i]", 'memory[i] = x[i] * float("nan")'),
        [f":{LINE}: update leaves nan in memory[0], q_w: let it be a finite number"],
    ),
    "a new memory in place of the old one": (
        (UPDATE, UPDATE + "    return memory\n"),
        [f":{LINE}: update returns array(", "let it change memory in place"],
    ),
    "an endless loop": (
        (UPDATE, UPDATE + "    while True:\n        dt = dt\n"),
        ["endless loop"],
    ),
    "a table of other things": (
        ("PARAMETERS = [gain(", "PARAMETERS = [3, gain("),
        ["PARAMETERS is not a table: write PARAMETERS = [gain(...), ...]"],
    ),
    "a default out of range": (
        ("(0.0, 1.0), 0.8", "(0.0, 1.0), 8.0"),
        ["the default of lag_share, 8, is not within 0 .. 1"],
    ),
    "a state twice": (('"spread"', '"samples"'), ["the state samples appears twice"]),
    "a parameter that every flight has": (
        ('"lag_share"', '"wind_x"'),
        ["the parameter wind_x is one of every flight: give it another name"],
    ),
    "a gain of the law": (('"lag_share"', '"kp_roll"'), ["kp_roll is one of pd: give it another"]),
}


def written(folder, old="", new="", name="wrong"):
    """Return the path of the filter's file with a text in place of another."""
    assert old in TEXT
    path = folder / f"{name}.py"
    path.write_text(TEXT.replace(old, new), encoding="utf-8")
    return path


@pytest.fixture
def mine(tmp_path):
    """Return a file with the shipped complementary filter's update, and settings of other names."""
    begin = inspect.getsource(complementary.initial_complementary)
    text = inspect.getsource(complementary).replace(begin, "")
    text += "\nfrom workbench.estimators import State, gain\n\nPARAMETERS = [\n"
    for name, value in ComplementarySettings()._asdict().items():
        name = name.replace("complementary", "mine")
        text += f'    gain("{name}", "1", (0.0, 100.0), {value}, "as the shipped one has it"),\n'
    size = complementary.COMPLEMENTARY_MEMORY_SIZE - 16
    text += f']\nMEMORY = [State(f"m_{{k}}", "1") for k in range({size})]\n'
    path = tmp_path / "mine.py"
    path.write_text(text, encoding="utf-8")
    return path


def flown(estimator, prefix):
    """Return a flight with a setting that changes, and another law that takes over."""
    script = [
        Action(at=0.2, velocity=[1.0, 0.5, 0.2]),
        Action(at=0.6, set={f"{prefix}_kp": 2.0}),
        Action(at=1.0, controller="pid"),
    ]
    session = Session(
        Scenario(estimator=str(estimator), script=script, duration=1.5),
        {f"{prefix}_velocity_time": 0.7},
    )
    session.run()
    return session


@pytest.mark.slow
def test_a_copy_of_the_shipped_filter_flies_and_is_judged_the_same(mine):
    own, shipped = flown(mine, "mine"), flown("complementary", "complementary")
    assert own.controller.name == shipped.controller.name == "pid"
    assert own.get("mine_kp") == shipped.get("complementary_kp") == 2.0
    one, other = own.recording(), shipped.recording()
    for each in ("q_WB", "p_WB", "estimate", "deviations"):
        assert getattr(one, each).tobytes() == getattr(other, each).tobytes()
    assert one.estimate.shape[0] > 100
    models = [LinearStudy(Scenario(estimator=str(e))).sampled() for e in (mine, "complementary")]
    assert np.array_equal(models[0].A, models[1].A)
    assert {"mine_m_4", "mine_m_10"} <= set(models[0].state_names)


def test_another_process_has_the_same_estimator(mine):
    session = flown(mine, "mine")
    law = pickle.loads(pickle.dumps(session.controller))
    assert law.estimator is session.controller.estimator
    assert pickle.loads(pickle.dumps(find_estimator("ekf"))) is find_estimator("ekf")


def test_the_phase_of_a_lag_is_its_closed_form(case):
    """Each sample takes away a share of what is missing; a model spreads samples over updates."""
    scenario = Scenario(estimator=str(LAG))
    study, period = LinearStudy(scenario), scenario.rates.control_period
    (gps,) = [each for each in choose_sensors(study.vehicle, scenario) if each.sensor.kind == "gps"]
    phases = PhaseStudy(study)
    for share in (0.8, 0.4):
        gains = {"lag_share": share}
        model = study.sampled(gains=gains)
        assert not [name for name in model.state_names if "lag" in name]  # nothing goes by them
        for w in (1.0, 3.0):
            kept = 1.0 - share * period / gps.period
            lag = -np.angle(1.0 - kept * np.exp(-1j * w * period))
            loops = {f"velocity_{axis}": w for axis in "xyz"}
            for budget in phases.budgets(model, loops, gains):
                with case(f"{budget.loop}, share {share}, {w} rad/s"):
                    assert math.degrees(budget.estimator - lag) == pytest.approx(0.0, abs=0.1)


def test_a_flight_begins_and_is_sure_as_the_file_says():
    session = Session(Scenario(estimator=str(LAG), sensors=SensorsConfig(noise=False), duration=1))
    session.run()
    recording = session.recording()
    assert recording.deviations == pytest.approx(0.2)
    assert recording.estimate[0, 4:7] == pytest.approx(recording.p_WB[0], abs=1e-9)
    assert session.get("lag_share") == 0.8
    with pytest.raises(WorkbenchError, match="lag_share is 2: keep it within 0 .. 1"):
        session.set("lag_share", 2.0)


def test_an_edit_waits_until_the_next_flight(tmp_path):
    """Another law that takes over goes on with the text that flies, and with its settings."""
    path = written(tmp_path, name="edited")
    session = Session(Scenario(estimator=str(path)), {"lag_share": 0.5})
    session.tick(0.2)
    text = TEXT.replace("0.2)]", '0.2), State("more", "1")]').replace("0.0, 0.2]", "0.0, 0.2, 0]")
    path.write_text(text, encoding="utf-8")
    session.fly_controller("pid")
    session.tick(0.2)
    assert session.get("lag_share") == 0.5
    assert session.controller.estimator.text == TEXT
    assert find_estimator(str(path)).text == text


def test_sliders_and_questions_have_its_parameters():
    subject = AnalysedVehicle(Scenario(estimator=str(LAG)), {"lag_share": 0.5})
    assert subject.own["lag_share"] == 0.5
    asked = {"lag_share": 0.4, "kp_pitch": 40.0}
    assert asked.items() <= subject.gains(asked).items()
    row = subject.table.find("lag_share")
    assert gain_label(row).group == "Estimator of your own" and not is_gain(row)
    assert controller_gains(asked) == loop_gains(asked) == asked


def complaint(read, *words):
    """Return what is said of a file, which is one line."""
    with pytest.raises(WorkbenchError) as refusal:
        read(*words)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


def test_what_is_wrong_in_a_file_is_one_sentence_about_it(tmp_path, case):
    for what, (change, parts) in WRONG.items():
        with case(what):
            path = written(tmp_path, *change)
            said = complaint(lambda file: check_scenario(Scenario(estimator=file)), str(path))
            for part in (str(path), *parts):
                assert part in said, said
    assert "no such file" in complaint(find_estimator, str(tmp_path / "none.py"))
    assert "no such module is installed" in complaint(find_estimator, "nobody.has.this")
    assert "unknown estimator 'efk': did you" in complaint(find_estimator, "efk")
    path = written(tmp_path, name="ekf")
    assert "has the name of the shipped ekf: give it" in complaint(find_estimator, str(path))


def test_what_goes_wrong_in_flight_is_a_sentence_too(tmp_path, case):
    counted = "        memory[SAMPLES] += 1.0\n"
    place = TEXT[: TEXT.index(counted)].count("\n") + 3
    for what, line, part in (
        ("NaN", "memory[0] *= 1e400 - 1e400", "update makes memory nan: let it be a finite"),
        ("nothing to divide by", "memory[0] /= memory[SAMPLES] - 3.0", "update fails: FloatingPoi"),
        ("a place beyond", "memory[int(memory[SAMPLES]) + 30] = 0.0", "update fails: IndexError"),
        ("no end", "while memory[0] < 9.0: memory[1] *= 1.0", "does not end: it has an endless"),
    ):
        with case(what):
            broken = f"{counted}        if memory[SAMPLES] == 3.0:\n            {line}\n"
            path = written(tmp_path, counted, broken)
            said = complaint(Session(Scenario(estimator=str(path))).run)
            assert f"{path}:{place}: {part}" in said


def test_what_only_python_can_run_flies(tmp_path):
    path = written(tmp_path, UPDATE, UPDATE + '    dt = float(f"{dt:.6f}")\n')
    session = Session(Scenario(estimator=str(path), duration=0.2))
    session.run()
    assert np.isfinite(session.recording().estimate).all()
