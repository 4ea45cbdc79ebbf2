"""The page plays alone, and drawing does not change the flight."""

import numpy as np

from workbench.design.flight_page import fly_and_film
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session


def test_the_film_is_one_page_and_the_flight_the_same_to_the_bit(tmp_path):
    scenario = Scenario(duration=0.5, script=[Action(at=0.1, velocity=[1.0, 0.0, 0.5])])
    shares: list[float] = []
    filmed = fly_and_film(scenario, {}, tmp_path / "film.html", shares.append)
    text = (tmp_path / "film.html").read_text(encoding="utf-8")
    assert len(text) > 1_000_000  # Meshcat itself is in it, and the scene
    assert 'src="http' not in text
    assert shares[-1] == 1.0
    session = Session(scenario)
    session.run()
    np.testing.assert_array_equal(filmed.recording().p_WB, session.recording().p_WB)
