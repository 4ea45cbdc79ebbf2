"""`workbench gui`, until there is one."""


def test_it_says_what_to_run_meanwhile(run):
    said = run("gui")
    assert said.code == 0
    assert said.out == ""
    assert "workbench reproduce" in said.err
