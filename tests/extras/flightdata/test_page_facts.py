"""What the pages of real flights list is what there is."""

import re

from tests.docs.test_page_facts import page
from workbench.extras.flightdata.predict.past import Effects
from workbench.extras.flightdata.predict.prediction import PREDICTION_METHODS
from workbench.extras.flightdata.predict_command import PREDICTION_EFFECTS
from workbench.extras.flightdata.readers.units import find_unit
from workbench.logs.logged_loop import LOGGED_LOOPS


def test_the_page_of_real_flights_names_units_and_loops():
    text = page("logs-of-real-flights.md")
    units = re.search(r"and their products: (.*?)\. There are also (.*?), and `g`", text, re.DOTALL)
    for unit in [*re.findall(r"`(.*?)`", units[1]), *re.findall(r"\w+", units[2]), "g"]:
        find_unit("1" if unit == "and" else unit)
    assert all(
        f"`{name}`" in text for name in ("roll_rate", "roll", "v_x", "x") if name in LOGGED_LOOPS
    )


def test_the_page_of_prediction_names_every_method_and_every_effect():
    assert Effects._fields == PREDICTION_EFFECTS
    for name in (*PREDICTION_METHODS, *PREDICTION_EFFECTS):
        assert name in page("prediction.md").lower(), name
