"""`workbench compile`: nothing is left to compile for the commands of the first morning."""

from workbench.common.compiled import Compiled
from workbench.design.executor import executor


def test_it_calls_every_compiled_function_that_frequent_commands_call(run, out, monkeypatch):
    called = set()

    def noting(self, *args, call=Compiled.__call__):
        called.add(self._what)
        return call(self, *args)

    monkeypatch.setattr(Compiled, "__call__", noting)
    sweep = ("sweep", "kp_pitch=200..250:2", "--axis", "x", "--duration", "0.2", "--json")
    for command in (("step", "--duration", "0.2", "--no-plots"), (*sweep, "--no-plots")):
        assert run(*command, "--output", out).code == 0
    needed = set(called)
    assert {"whole flights", "flights by the thousand"} <= needed
    called.clear()
    monkeypatch.setattr(executor, "all_cores", executor.InThisProcess)
    said = run("compile", "--json")
    assert said.code == 0, said.err
    assert needed <= called
    app = {"the control law", "the IMU", "the estimator ekf", "rays against shapes", "the gyro"}
    assert app | {"batches of flights"} < called
    assert said.json["seconds"] > 0.0
