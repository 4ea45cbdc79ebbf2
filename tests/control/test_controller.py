"""What is wrong in a controller's file is told in one sentence: file, line, what to write."""

import math
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.installed_laws import installed_laws
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.batch import Batch
from workbench.design.rollout.flights import make_fly_block
from workbench.design.rollout.gyro import TRUE_STATE
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

OWN = Path(__file__).parents[1] / "controllers/cascade.py"
TEXT = OWN.read_text()
ARGUMENTS = "measured, setpoint, g, vehicle, memory, dt, loops"
UPDATE = f"def update({ARGUMENTS}):\n"
BEGIN = "    e_x, e_y, e_z = position_error(measured, setpoint)\n"
RETURN = "    return (vehicle.mass * f[2], m_x, m_y, m_z), (climb,)\n"
LINE = TEXT[: TEXT.index(UPDATE)].count("\n") + 1
LAST = TEXT.count("\n")
DESIGN = "\n\ndef design(vehicle, g, dt):\n    return "
STATES = 'MEMORY = [State("climb", "m/s^2")]\n'
WRONG = {
    "a module that is not there": (
        (
            "from workbench.controllers import (",
            "import no_such_module\nfrom math import (\n    pi,",
        ),
        [":3: ModuleNotFoundError: No module named 'no_such_module'", "install what is missing"],
    ),
    "a name that the interface has not": (
        ("    GRAVITY,\n", "    GRAVITI,\n"),
        [
            ":3: ImportError: cannot import name 'GRAVITI'",
            "import what workbench.controllers names",
        ],
    ),
    "no Python": ((STATES, "MEMORY = [State(\n"), ["'(' was never closed", "correct this line"]),
    "no update": (("def update(", "def updates("), [f"write def update({ARGUMENTS})"]),
    "an update that is no function": (
        (UPDATE, f"update = 3\n\n\ndef f({ARGUMENTS}):\n"),
        ["write def"],
    ),
    "other arguments": (
        (UPDATE, "def update(measured, g):\n"),
        [f":{LINE}: update takes (measured, g): let it take ({ARGUMENTS})"],
    ),
    "a loop point that is none": (
        ('"speed", "speed_x"', '"speed", "speed_y"'),
        ["the loop speed has unknown loop point 'speed_y': did you mean 'speed_x'?"],
    ),
    "a gain of a loop that is none": (
        ('gains=("k_speed",)', 'gains=("k_sped",)'),
        ["the loop speed has unknown gain 'k_sped': did you mean 'k_speed'?"],
    ),
    "an axis that is none": (
        ('axis="x", gains=("k_speed"', 'axis="X", gains=("k_speed"'),
        ["unknown axis 'X'"],
    ),
    "a gain twice": (
        ('"k_turn", "1/s"', '"k_tilt", "1/s"'),
        ["parameter k_tilt appears twice: leave"],
    ),
    "a common gain": (
        ('"k_turn", "1/s"', '"max_tilt", "1/s"'),
        ["the parameter max_tilt appears twice"],
    ),
    "a gain that is no name": (
        ('"k_turn", "1/s"', '"k turn", "1/s"'),
        ["'k turn' is not a name for a parameter"],
    ),
    "a state twice": (
        (STATES, STATES[:-2] + ', State("climb", "m")]\n'),
        ["state climb appears twice"],
    ),
    "a state that begins nowhere": (
        (STATES, 'MEMORY = [State("climb", "m/s^2", float("nan"))]\n'),
        ["the state climb begins with nan: write a finite number"],
    ),
    "tables of other things": (
        (STATES, "MEMORY = ['climb']\n"),
        ["write MEMORY = [State(...), ...]"],
    ),
    "points without units": (
        ('"m/s", "pitch": "rad/s^2"', '1, "pitch": 2'),
        ["POINTS is not a table: write {"],
    ),
    "a default out of range": (
        ("(0.0, 5.0), 0.7", "(0.0, 5.0), 7.0"),
        ["the default of k_place, 7, is not within 0 .. 5: change"],
    ),
    "a gain that is not there": (
        ("g.k_yaw * a_z", "g.k_jaw * a_z"),
        ["update fails: AttributeError", "no attribute 'k_jaw'", "it has k_place, k_speed"],
    ),
    "NaN": (
        (RETURN, RETURN.replace("m_z)", "m_z * (1e400 - 1e400))")),
        ["nan as m_z of the wrench: let it be a finite"],
    ),
    "a division by nothing": (
        (BEGIN, BEGIN + "    e_x = e_x / measured.v_WBcm[0]\n"),
        [f":{LINE + 2}: update fails: ZeroDivisionError"],
    ),
    "too few memories": (
        (RETURN, RETURN.replace("(climb,)", "()")),
        [" as memory: let it be a tuple of 1 numbers, climb"],
    ),
    "too many memories": (
        (RETURN, RETURN.replace("(climb,)", "(climb, climb)")),
        ["with 2 places as memory: let it be a tuple of 1 numbers, climb"],
    ),
    "three numbers of a wrench": (
        (RETURN, RETURN.replace(", m_z)", ")")),
        [f":{LINE}: update returns", "as wrench: let it be a tuple of 4 numbers, F, m_x, m_y, m_z"],
    ),
    "no memory at all": (
        (RETURN, "    return m_x\n"),
        ["let it return (F, m_x, m_y, m_z) and the memory"],
    ),
    "text for a number": (
        (RETURN, RETURN.replace("(climb,)", "('a',)")),
        ["'a' as climb of the memory"],
    ),
    "an endless loop at import": (
        (STATES, STATES + "while True:\n    pass\n"),
        ["does not end: it has an endless loop"],
    ),
    "an endless loop in an update": (
        (BEGIN, BEGIN + "    while dt > 0.0:\n        e_x = 0.0\n"),
        ["does not end: it has an endless loop"],
    ),
    "an exit": ((STATES, STATES + "raise SystemExit('bye')\n"), ["SystemExit: bye"]),
    "a designed number without its maker": (
        (STATES, STATES + 'DESIGNED = ["k_own"]\n'),
        ["DESIGNED and design(vehicle, g, dt) belong together"],
    ),
    "too many designed numbers": (
        (UPDATE, 'DESIGNED = ["k_own"]' + DESIGN + "[1.0, 2.0]\n\n\n" + UPDATE),
        ["design returns [1.0, 2.0]: let it return 1 finite numbers"],
    ),
    "designed numbers that are none": (
        (UPDATE, 'DESIGNED = ["k_own"]' + DESIGN + "[1.0 / (g.k_speed - 2.5)]\n\n\n" + UPDATE),
        ["design fails: ZeroDivisionError"],
    ),
    "a designed name of a gain": (
        (UPDATE, 'DESIGNED = ["k_yaw"]' + DESIGN + "[1.0]\n\n\n" + UPDATE),
        ["the parameter k_yaw appears twice"],
    ),
}


def written(folder: Path, change: tuple[str, str] | None = None) -> Path:
    path = folder / "my_law.py"
    text = TEXT
    if change:
        assert text.count(change[0]) == 1, change
        text = text.replace(*change)
    path.write_text(text)
    return path


def complaint(path: Path, do=load_controller) -> str:
    with pytest.raises(WorkbenchError) as caught:
        do(path)
    said = str(caught.value)
    assert said.startswith(str(path)), said
    assert "\n" not in said and len(said) < 600, said
    return said


def test_what_is_wrong_in_a_file_is_one_sentence_about_it(tmp_path, case):
    for what, (change, parts) in WRONG.items():
        with case(what):
            said = complaint(written(tmp_path, change))
            for part in parts:
                assert part in said, said


def test_a_file_that_is_not_there_or_no_text(tmp_path):
    assert "no such file" in complaint(tmp_path / "none.py")
    (tmp_path / "binary.py").write_bytes(b"\xff\xfe\x00")
    assert "is not a text in UTF-8" in complaint(tmp_path / "binary.py")
    with pytest.raises(WorkbenchError, match="unknown controller 'pdi': did you mean 'p"):
        load_controller("pdi")
    with pytest.raises(WorkbenchError, match="no such module is installed"):
        load_controller("nobody.has.this")


def test_a_name_of_every_flight_is_refused(tmp_path):
    path = written(tmp_path, ('"k_turn", "1/s"', '"wind_x", "1/s"'))
    text = path.read_text().replace("g.k_turn", "g.wind_x").replace('"k_turn")', '"wind_x")')
    path.write_text(text)
    said = complaint(path, lambda file: load_controller(file).table)
    assert "the parameter wind_x is one of every flight: give it another name" in said


def test_what_knows_no_derivative_flies_and_says_so_to_linear_models(tmp_path):
    path = written(tmp_path, (BEGIN, BEGIN + "    e_x = math.sin(e_x)\n"))
    path.write_text("import math\n" + path.read_text())
    said = complaint(path, lambda file: LinearStudy(Scenario(controller=str(file))).sampled())
    assert f":{LINE + 3}: update fails: TypeError" in said
    assert "write the function with those" in said


def test_what_cannot_be_compiled_flies_and_its_line_is_in_the_message(tmp_path):
    """Python flies it; the sentence comes where machine code is made."""
    path = written(tmp_path, (BEGIN, BEGIN + '    e_x = float(f"{e_x:.6f}")\n'))
    session = Session(Scenario(controller=str(path), start=ScenarioStart(position=[0.0, 0.0, 9.0])))
    session.tick(0.1)
    said = complaint(path, lambda file: Batch(1, controller=str(file)).step())
    assert "cannot be compiled" in said and "write it with numbers" in said
    assert f":{LINE + 2}: " in said


def test_every_shipped_law_passes_the_trial_of_a_file(tmp_path, case):
    for name in installed_laws():
        with case(name):
            shipped = load_controller(name)
            path = tmp_path / f"my_{name}.py"
            path.write_text(shipped.text)
            own = load_controller(path)
            assert not own.shipped and own.digest == shipped.digest
            assert [row.name for row in own.parameters] == [row.name for row in shipped.parameters]
            assert all(math.isfinite(row.default) for row in own.parameters)


def test_functions_of_two_laws_have_names_of_their_own(tmp_path):
    """By name machine code is found: with one name, a process flew the first law for the second."""
    path = written(tmp_path)
    before = load_controller(path)
    path.write_text(TEXT + "# edited\n")
    laws = [before, load_controller(path), *map(load_controller, installed_laws())]
    made = [
        (function.__module__, function.__qualname__)
        for law in laws
        for function in (law.update, *flight_law(law)[2:], make_fly_block(law, TRUE_STATE))
    ]
    assert len(set(made)) == len(made)
