"""Compensators of python-control within a law."""

import control
import numba
import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.jitable import register_with_numba
from workbench.common.resources import controllers_dir
from workbench.control.compensator import compensator
from workbench.control.controller import user_record_type
from workbench.control.controller_file import load_controller
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.agreement import agreement, random_trials
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

LEAD = control.tf([0.12, 1.0], [0.01, 1.0])
# two slow and two oscillating poles, all entries used. Not of `control.rss`: it draws another
# system in each run, and some of these have a transfer function that scipy refuses
FOUR_STATES = control.ss(
    [[-1.0, 0.3, 0.0, 0.1], [0.0, -5.0, 0.4, 0.0], [0.2, 0.0, -3.0, 20.0], [0.0, 0.1, -20.0, -3.0]],
    [[1.0], [0.5], [-2.0], [0.7]],
    [[0.4, -1.0, 0.3, 0.9]],
    0.25,
)
DT = 1 / 128
NOTCH = """
from workbench.controllers import compensator
import control

NOTCH = compensator("notch", {system})
notch = NOTCH.run
MEMORY = NOTCH.memory
DESIGNED = NOTCH.designed


def design(vehicle, g, dt):
    return NOTCH.design(dt)

"""


def law_with(folder, name, system):
    """Return the PD cascade with a compensator behind what roll asks for."""
    text = (controllers_dir() / "pd.py").read_text(encoding="utf-8")
    head, update = text.split("def update(", 1)
    update = update.replace(
        "    alpha = probe3(attitude_pd(e, w, w_sp, vehicle, g), TURN_POINT",
        "    a_x, a_y, a_z = attitude_pd(e, w, w_sp, vehicle, g)\n"
        "    a_x, memory = notch(a_x, g, memory)\n"
        "    alpha = probe3((a_x, a_y, a_z), TURN_POINT",
    )
    path = folder / f"{name}.py"
    path.write_text(f"{head}{NOTCH.format(system=system)}\ndef update({update}", encoding="utf-8")
    return str(path)


def run(part, inputs, dt):
    """Return what a compensator makes of inputs, as a law runs it."""
    g = user_record_type("G", part.designed)(*part.design(dt))
    memory_of = user_record_type("M", [state.name for state in part.memory])
    memory, outputs = tuple(state.initial for state in part.memory), []
    for u in inputs:
        y, memory = part.run(float(u), g, memory_of(*memory) if memory else ())
        outputs.append(y)
    return np.array(outputs)


@pytest.mark.parametrize("method", ["tustin", "zoh", "foh"])
@pytest.mark.parametrize(
    "system",
    [
        LEAD,
        control.tf([1.0, 2.0, 900.0], [1.0, 30.0, 900.0]),
        FOUR_STATES,
    ],
    ids=["lead", "notch", "four_states"],
)
def test_it_answers_as_python_control_says(system, method):
    inputs = np.random.default_rng(1).normal(size=200)
    if method == "foh" and not isinstance(system, control.TransferFunction):
        system = control.ss2tf(system)
    part = compensator("c", system, method)
    sampled = control.sample_system(control.ss(system), DT, method)
    expected = control.forced_response(sampled, inputs=inputs).outputs
    np.testing.assert_allclose(run(part, inputs, DT), expected, rtol=0, atol=1e-9)


def test_compiled_code_runs_it():
    part = compensator("c", LEAD)
    g = user_record_type("G", part.designed)(*part.design(DT))
    memory = user_record_type("M", ["c_1"])(0.5)
    register_with_numba()
    assert numba.njit(part.run)(0.25, g, memory) == part.run(0.25, g, memory)


def test_in_a_law_it_multiplies_the_open_loop(tmp_path):
    """L with the compensator = its frequency response times L without, at any frequency."""
    none = law_with(tmp_path, "with_none", "control.tf([1.0, 5.0], [1.0, 5.0])")
    lead = law_with(tmp_path, "with_lead", "control.tf([0.12, 1.0], [0.01, 1.0])")
    w = np.logspace(0, 2, 30)
    found = [
        LinearStudy(Scenario(controller=name)).sampled().open_loop("roll_acceleration")
        for name in (none, lead)
    ]
    plain, whole = (each(np.exp(1j * w * DT)) for each in found)
    series = control.sample_system(control.ss(LEAD), DT, "tustin")(np.exp(1j * w * DT))
    np.testing.assert_allclose(whole, series * plain, rtol=1e-7)


@pytest.mark.slow
def test_such_a_law_flies_equally_in_the_diagram_and_compiled(tmp_path):
    notch = law_with(tmp_path, "with_notch", "control.tf([1.0, 2.0, 900.0], [1.0, 30.0, 900.0])")
    session = Session(Scenario(controller=notch))
    session.command(velocity=(1.0, 0.0, 0.0))
    session.tick(4.0)
    assert session.snapshot().v_WB[0] == pytest.approx(1.0, abs=0.05)
    law, own = session.controller, session.parameters()
    gains = {row.name: own[row.name] for row in law.parameters}
    trials = random_trials(session.vehicle, gains, 2, 3, law)
    found = agreement(Scenario(controller=notch), trials, duration=3.0)
    assert found.velocity.max() < 2e-3 and found.angular_velocity.max() < 2e-2  # two integrators


def test_what_is_none_is_refused_with_what_to_do(case):
    sampled = control.ss(1.0, 1.0, 1.0, 0.0, 0.01)
    two_outputs = control.ss(-np.eye(2), np.ones((2, 1)), np.eye(2), 0.0)
    twenty_states = control.ss(-np.eye(20), np.ones((20, 1)), np.ones((1, 20)), 0.0)
    for system, method, said in (
        (3.0, "tustin", "give control.ss"),
        (control.tf([1.0, 0.0], [1.0]), "tustin", "more zeros than poles: add a fast pole"),
        (two_outputs, "tustin", "has 1 inputs and 2 outputs"),
        (twenty_states, "tustin", "has 20 states: reduce it to 12"),
        (LEAD, "exact", "choose one of tustin, zoh"),
        (control.tf([2.0], [1.0]), "tustin", "has no states: multiply by its gain"),
        (sampled, "tustin", "is sampled at 0.01 s, and the law at 0.0078125 s"),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said):
            compensator("c", system, method).design(DT)
    with pytest.raises(WorkbenchError, match="letters, digits and _"):
        compensator("my notch", LEAD)


def test_a_law_states_its_coefficients_and_states(tmp_path):
    law = load_controller(law_with(tmp_path, "stated", "control.tf([1.0], [0.1, 1.0])"))
    assert [state.name for state in law.memory] == ["notch_1"]
    assert law.designed == ("notch_a11", "notch_b1", "notch_c1", "notch_d")
