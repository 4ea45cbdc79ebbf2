"""Figure of a step response that was measured out of ordinary flying."""

from matplotlib.figure import Figure

from workbench.design.plots import PALETTE, label, legend, stacked, styled
from workbench.logs.flight_record import FlightRecord
from workbench.logs.step_response import StepEstimate


@styled
def plot_step_response(flight: FlightRecord, estimate: StepEstimate) -> Figure:
    """Return a figure of a step response with its spread, and of why it is not to be trusted."""
    title = f"{flight.name}: step response of {estimate.name}"
    figure, (axes,) = stacked(title, 1, width=8.0, height=3.6)
    color = PALETTE.series[0]
    axes.axhline(1.0, color=PALETTE.series[1], lw=1.0, ls="--", label=estimate.setpoint)
    axes.fill_between(
        estimate.time, estimate.low, estimate.high, color=color, alpha=0.2, lw=0.0, label="95 %"
    )
    axes.plot(
        estimate.time,
        estimate.values,
        color=color,
        ls="-" if estimate.trusted else ":",
        label=estimate.response,
    )
    top = max(float(estimate.high.max()), 1.1)
    axes.set_ylim(min(float(estimate.low.min()), -0.1), 1.05 * top)
    axes.set_xlim(float(estimate.time[0]), float(estimate.time[-1]))
    said = f"{estimate.windows} windows, coherence {estimate.coherence:.2f}"
    label(axes, said if estimate.trusted else f"NOT TO BE TRUSTED, {said}", "[1]")
    legend(axes)
    axes.set_xlabel("time since the step [s]")
    return figure
