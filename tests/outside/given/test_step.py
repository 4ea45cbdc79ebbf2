"""A test of a user's own, with the fixture of the pytest plugin."""


def test_the_drone_climbs_without_overshoot(step_response):
    step = step_response("z", 0.5, duration=1.0)
    assert step.metrics.overshoot < 5.0
