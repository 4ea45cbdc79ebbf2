"""`workbench frequency-response`: a loop measured in flight, beside its linear model."""

import argparse
import math
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_output_options,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_result, print_table
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.design.judge.loop_measurement import Measurement


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "frequency-response",
        "Measure a loop in flight with a multisine, and set it beside its linear model.",
        "workbench frequency-response velocity_x\n"
        "  workbench frequency-response pitch --set turbulence=7.7 --periods 12",
        run,
    )
    parser.add_argument("loop", metavar="LOOP", help="as velocity_x, pitch, yaw_rate, position_z")
    parser.add_argument(
        "--cut",
        choices=("actuator", "error"),
        default="actuator",
        help="where the loop is opened (default: actuator)",
    )
    parser.add_argument(
        "--lowest",
        type=float,
        default=0.5,
        metavar="W",
        help="frequency in rad/s; a period is as long as its wave (default: 0.5)",
    )
    parser.add_argument(
        "--highest",
        type=float,
        metavar="W",
        help="frequency in rad/s (default: 4 times the loop's bandwidth or crossover)",
    )
    parser.add_argument(
        "--periods",
        type=int,
        default=8,
        metavar="N",
        help="flown, the first of which is not measured (default: 8)",
    )
    parser.add_argument(
        "--size",
        type=float,
        metavar="A",
        help="rms of what is injected, in the loop point's unit (default: what the linear model "
        "says that the drone bears)",
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Measure, print, write table and picture."""
    from workbench.design.judge.loop_measurement import fly_measurement
    from workbench.scenario.scenario import Scenario

    scenario = with_vehicle(Scenario(), args)
    with Outputs() as outputs:
        table = outputs.add(args.output / f"frequency-response-{args.loop}.csv")
        plot = outputs.picture(args, f"frequency-response-{args.loop}.png")
        with progress_bar(f"measuring {args.loop}") as progress:
            found = fly_measurement(
                args.loop,
                cut=args.cut,
                scenario=scenario,
                settings=dict(args.set),
                size=args.size,
                lowest=args.lowest,
                highest=args.highest,
                periods=args.periods,
                progress=progress,
            )
        found.write_csv(table)
        if plot:
            from workbench.design.judge.plots import plot_measurement
            from workbench.design.plots import write_png

            write_png(plot_measurement(found), plot)
    print_result(
        args, _result(found) | {"files": outputs.files}, _print, found, files=outputs.files
    )
    return ExitCode.DONE


def _result(found: "Measurement") -> dict[str, Any]:
    """Return what JSON has; angles in rad."""
    return {
        "vehicle": found.vehicle,
        "loop": found.loop,
        "cut": found.cut,
        "injection": found.injection,
        "periods": found.measured.periods,
        "bandwidth": found.margins.bandwidth,
        "rows": found.rows(),
    }


def _print(found: "Measurement") -> None:
    """Print a row for each frequency."""
    injection = found.injection
    print(
        f"{found.vehicle}: {found.loop}, opened at the {found.cut}: {injection.size:.3g} rms "
        f"injected at {injection.point}, {found.measured.periods} periods of "
        f"{2.0 * math.pi / injection.lowest:.3g} s measured"
    )
    head = ("frequency", "coherence", "measured", "", "spread", "model", "", "difference", "")
    rows: list[tuple[str, ...]] = [head]
    rows.append(("[rad/s]", "", "[dB]", "[deg]", "[dB]", "[dB]", "[deg]", "[dB]", "[deg]"))
    for row in found.rows():
        if row["coherence"] < 0.005:
            rows.append((f"{row['frequency']:.3g}", "0.00", *["-"] * 7))
            continue
        rows.append(
            (
                f"{row['frequency']:.3g}",
                f"{row['coherence']:.2f}",
                *_size_and_phase(row["measured_size"], row["measured_phase"]),
                f"{20.0 * math.log10(1.0 + row['deviation']):.2f}",
                *_size_and_phase(row["model_size"], row["model_phase"]),
                *_size_and_phase(
                    row["measured_size"] / row["model_size"],
                    math.remainder(row["measured_phase"] - row["model_phase"], math.tau),
                ),
            )
        )
    print_table(rows)
    said = found.worst()
    if said is None:
        print(
            "nothing was measured with a coherence of 0.9 up to the bandwidth: give more --periods "
            "or a larger --size"
        )
        return
    size, phase = said
    print(
        f"up to the bandwidth, {found.margins.bandwidth:.3g} rad/s, and where the coherence is 0.9 "
        f"or more, flight and model differ by {size:.2f} dB and {math.degrees(phase):.1f} deg at "
        "most"
    )


def _size_and_phase(size: float, phase: float) -> tuple[str, str]:
    return f"{20.0 * math.log10(size):.2f}", f"{math.degrees(phase):.1f}"
