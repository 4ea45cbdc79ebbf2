"""`workbench controllers`."""

import importlib

import pytest

from workbench.control.controller import COMMON_PARAMETERS
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws, known_laws

LAW = '''"""Speed alone: nothing turns."""

from workbench.controllers import gain, State

PARAMETERS = [gain("k", "1/s", (0.0, 9.0), 3.0, "acceleration per error")]
MEMORY = [State("before", "m/s", 0.5)]


def update(measured, setpoint, g, vehicle, memory, dt, loops):
    """Return a wrench and the memory."""
    return (vehicle.mass * 9.81, 0.0, 0.0, 0.0), (memory.before,)
'''


def test_all_shipped_ones_are_listed_with_what_they_are(run):
    said = run("controllers")
    assert said.code == 0, said.err
    head, *rows = said.out.splitlines()
    assert head.split()[:4] == ["name", "parameters", "memory", "loops"]
    assert [row.split()[0] for row in rows] == [*known_laws()]
    assert "PD cascade" in rows[0]
    stated = run("controllers", "--json").json["controllers"]
    for name, found in zip(installed_laws(), stated[: len(installed_laws())], strict=True):
        law = load_controller(name)
        assert found["name"] == name
        assert [row["name"] for row in found["parameters"]] == [p.name for p in law.parameters]
        assert found["points"] == law.points
        assert found["loops"][0]["actuator"] == law.loops[0].point("actuator")
        assert found["sha256"] == law.digest


def test_a_file_of_ones_own_is_shown(run, write):
    path = write("my_law.py", LAW)
    said = run("controllers", path)
    assert said.code == 0, said.err
    assert said.out.startswith("my_law: Speed alone: nothing turns.\n")
    rows = {line.split()[0]: line.split() for line in said.out.splitlines() if line.strip()}
    assert rows["k"][:5] == ["k", "1/s", "0", "9", "3"]
    assert rows["before"] == ["before", "m/s", "0.5"]
    assert "no loops" in said.out
    assert "no loop points" in said.out
    assert "no rule" in said.out
    found = run("controllers", path, "--json").json
    assert found["what"] == "Speed alone: nothing turns."
    assert len(found["parameters"]) == 1 + len(COMMON_PARAMETERS)
    assert found["memory"] == [{"name": "before", "unit": "m/s", "initial": 0.5}]


def test_a_file_that_does_not_load_is_a_sentence(refused, write, case):
    for text, word in (
        ("PARAMETERS = [", ":1: "),
        ("import math\n", "has no update"),
        (LAW.replace("(0.0, 9.0)", "(5.0, 9.0)"), "the default of k"),
        (LAW + "\n1 / 0\n", "ZeroDivisionError"),
    ):
        with case(word):
            assert word in refused("controllers", write("my_law.py", text))
    assert "did you mean 'pid'" in refused("controllers", "pidd")


@pytest.mark.parametrize("name", installed_laws())
def test_every_table_of_a_shipped_one_prints(run, name):
    said = run("controllers", name)
    assert said.code == 0, said.err
    assert "velocity_z" in said.out


def test_kept_machine_code_of_a_file_finds_its_module_by_name(write):
    """numba imports the module of what it loads; two texts of one name are two modules."""
    laws = [load_controller(write("my_law.py", LAW + end)) for end in ("", "# edited\n")]
    names = {law.update.__module__ for law in laws}
    assert len(names) == 2
    for law in laws:
        assert importlib.import_module(law.update.__module__).update is law.update
