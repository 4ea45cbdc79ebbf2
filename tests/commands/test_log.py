"""`workbench log` of our own logs."""


def test_log_says_what_is_in_it(run, log):
    said = run("log", log)
    assert said.code == 0
    assert "flight: workbench log, workbench" in said.out
    assert any(line.split()[0] == "position_data" for line in said.out.splitlines() if line)
    found = run("log", log, "--json").json
    assert found["parameters"]["vehicle"] == "dh_drone" and found["end"] > 0.25
    assert not found["remarks"]


def test_what_cannot_be_done_is_a_sentence(run, refused, log, tmp_path, case):
    strange = tmp_path / "strange.log"
    strange.write_bytes(b"strange")
    for command, said in (
        (("log", tmp_path / "gone"), "no such file"),
        (("log", strange), "is not a known kind of log: name a log of the workbench (.mcap)"),
        (("log", log, "--log-number", "2"), "has one log"),
        (("plot", log, "imu", "--span", "3", "1"), "let it end after it begins"),
        (("plot", log, "position_data", "--span", "30", "31"), "nothing between"),
        (("plot", log, "--over", log), "name some"),
        (("plot", log, "--step-response", "roll_rate"), "has no rate_setpoint.w_x"),
    ):
        with case(command):
            assert said in refused(*command)
