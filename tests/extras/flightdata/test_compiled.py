"""Compiled code of this package is compiled again when a file of it changes."""

from tests.common.test_compiled import check_watched
from workbench.extras.flightdata.identify import model_rows
from workbench.extras.flightdata.predict import flown


def test_every_file_of_what_is_compiled_is_watched():
    check_watched("workbench.extras.flightdata.identify.model_rows", model_rows.FIT_SOURCES)
    check_watched("workbench.extras.flightdata.predict.driven", flown.PREDICT_SOURCES)
