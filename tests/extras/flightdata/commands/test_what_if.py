"""`workbench what-if`: what it refuses; tests/extras/flightdata/predict has the flights."""


def test_a_name_that_is_no_gain_of_the_law_is_refused_with_the_nearest(refused, log, tmp_path):
    words = ("what-if", log, "--model", "dh_drone", "--output", tmp_path / "out")
    for law, name, near in (
        ((), "kp_velocty_x", "kp_velocity_x"),
        (("--controller", "crazyflie"), "pid_rate_rol_kd", "pid_rate_roll_kd"),
    ):
        said = refused(*words, *law, "--set", f"{name}=2")
        assert f"unknown parameter of {law[1] if law else 'pd'} '{name}': did you" in said
        assert f"did you mean '{near}'?" in said
    assert "unknown parameter of pd 'wind_x'" in refused(*words, "--set", "wind_x=2")
    assert not (tmp_path / "out").exists()
