"""Public names, each loaded on first use."""

from workbench.extras.flightdata.identify.flight import excitation as excitation
from workbench.extras.flightdata.identify.flight import usual_limits as usual_limits
from workbench.extras.flightdata.identify.measured import measured_flight as measured_flight
from workbench.extras.flightdata.identify.plots_identified import plot_identified as plot_identified
from workbench.extras.flightdata.identify.report import make_report as make_report
from workbench.extras.flightdata.predict.logged import motion_of as motion_of
from workbench.extras.flightdata.predict.plots_predict import plot_predictions as plot_predictions
from workbench.extras.flightdata.predict.plots_predict import plot_what_if as plot_what_if
from workbench.extras.flightdata.predict.prediction import Predictor as Predictor
from workbench.extras.flightdata.predict.prediction_summary import summarized as summarized
from workbench.extras.flightdata.predict.what_if import Explained as Explained
from workbench.extras.flightdata.predict.what_if import Law as Law
from workbench.extras.flightdata.predict.what_if import Uncertainty as Uncertainty
