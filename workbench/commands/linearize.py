"""`workbench linearize`, and `frequency-response`, which measures the same in flight."""

import argparse
import math
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup, flown_with
from workbench.commands.judgement_tables import print_modes
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flight_options,
    add_json_option,
    add_option,
    add_vehicle_options,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_message, print_result, print_table
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.design.judge.loop_measurement import Measurement
    from workbench.design.linear.model import Matrices


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "linearize",
        "Give the exact linear model of the closed loop, the vehicle, or an opened loop, at a trim "
        "point: its order and poles, or with --json its matrices with the names of all signals.",
        "workbench linearize --at vx=5 --loop pitch --minimal",
        run,
    )
    add_vehicle_options(parser)
    add_option(
        parser,
        "--at",
        "POINT",
        "hover, or as vx=5,vz=-1,yaw_rate=0.2 [m/s, rad/s]; ax, ay, az [m/s²] for an "
        "instant of an accelerated flight; hold=1 while the position is held",
        "hover",
    )
    add_option(
        parser,
        "--loop",
        "NAME",
        "closed, vehicle, or the loop to open: velocity_x, velocity_y, velocity_z, roll, "
        "pitch, yaw_rate, position_x, position_y, position_z",
        "closed",
    )
    parser.add_argument(
        "--cut", default="actuator", metavar="PLACE", help="open it at its actuator or its error"
    )
    add_option(
        parser,
        "--time",
        "KIND",
        "sampled, with hold and delay as they fly, or continuous",
        "sampled",
    )
    parser.add_argument(
        "--inputs", metavar="NAME[,NAME]", help="inputs wanted (default: what the pilot commands)"
    )
    parser.add_argument(
        "--outputs", metavar="NAME[,NAME]", help="outputs wanted (default: velocity and yaw rate)"
    )
    parser.add_argument(
        "--minimal", action="store_true", help="leave out states that play no part between them"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Linearise and print."""
    from workbench.design.linear.linearize import linear_matrices

    setup = chosen_setup(args)
    law = setup.controller
    if law.derivatives != "AutoDiff":
        print_message(
            f"{law.name} does not convert to AutoDiffXd: its derivatives are {law.derivatives}"
        )
    system = linear_matrices(
        setup,
        at=args.at,
        loop=args.loop,
        cut=args.cut,
        time=args.time,
        inputs=_names(args.inputs),
        outputs=_names(args.outputs),
        minimal=args.minimal,
    )
    result = {
        "at": args.at,
        "loop": args.loop,
        "period": float(system.dt),
        "states": list(system.state_labels),
        "inputs": list(system.input_labels),
        "outputs": list(system.output_labels),
        **{name: getattr(system, name).tolist() for name in "ABCD"},
    }
    joints = [name for name, _ in setup.vehicle.small_joint_signals]
    print_result(args, result, _print, system, joints, args)
    return ExitCode.DONE


def _print(system: "Matrices", joints: list[str], args: argparse.Namespace) -> None:
    """Print order and poles, fast ones last, in the terms of `control.damp`."""
    from workbench.design.judge.loop_response import MAX_INTEGRATOR_RATE
    from workbench.design.judge.modes import modes_of, named_poles, natural_poles

    kind = f"sampled each {1e3 * system.dt:.4g} ms" if system.dt else "continuous"
    print(f"{args.loop} at {args.at}, {kind}, {flown_with(args)}: {len(system.A)} states")
    print(f"inputs:  {', '.join(system.input_labels)}")
    print(f"outputs: {', '.join(system.output_labels)}")
    poles, names = system.poles, []
    if joints and system.state_labels:
        poles, names = named_poles(system.A, system.state_labels, joints)
    modes = [mode for mode in modes_of(poles, system.dt, names) if not mode.gone_after(system.dt)]
    print_modes(modes)
    integrators = int((abs(natural_poles(poles, system.dt)) <= MAX_INTEGRATOR_RATE).sum())
    # a pair is one mode of two poles; a lone sampled pole at negative z swings at half the rate
    pairs = sum(0.0 < mode.imaginary < _half_rate(system.dt) for mode in modes)
    gone = len(system.A) - integrators - len(modes) - pairs
    if integrators:
        print(f"{integrators} {'integrator' if integrators == 1 else 'integrators'}")
    if gone:
        print(f"{gone} more {'dies' if gone == 1 else 'die'} out within a sample")


def _half_rate(period: float) -> float:
    """Return the Nyquist frequency [rad/s], minus rounding errors."""
    return 0.999999 * math.pi / period if period else math.inf


def _names(text: str | None) -> list[str] | None:
    """Return the names of a list separated by commas, None for none."""
    return [name.strip() for name in text.split(",")] if text else None


def add_frequency_response(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "frequency-response",
        "Measure a loop in flight with a multisine, and compare it with its linear model.",
        "workbench frequency-response velocity_x\n"
        "  workbench frequency-response pitch --set turbulence=7.7 --periods 12",
        run_frequency_response,
    )
    parser.add_argument("loop", metavar="LOOP", help="as velocity_x, pitch, yaw_rate, position_z")
    parser.add_argument(
        "--cut",
        choices=("actuator", "error"),
        default="actuator",
        help="where the loop is opened (default: actuator)",
    )
    add_option(parser, "--lowest", "W", "frequency [rad/s]; a period is as long as its wave", 0.5)
    parser.add_argument(
        "--highest",
        type=float,
        metavar="W",
        help="frequency [rad/s] (default: 4 times the loop's bandwidth or crossover)",
    )
    add_option(parser, "--periods", "N", "flown, the first of which is not measured", 8)
    parser.add_argument(
        "--size",
        type=float,
        metavar="A",
        help="rms of what is injected, in the loop point's unit (default: as much as the drone "
        "can take by the linear model)",
    )
    add_flight_options(parser)


def run_frequency_response(args: argparse.Namespace) -> int:
    """Measure, print, write table and picture."""
    from workbench.design.judge.loop_measurement import fly_measurement

    setup = chosen_setup(args)
    with Outputs() as outputs:
        table = outputs.add(args.output / f"frequency-response-{args.loop}.csv")
        plot = outputs.picture(args, f"frequency-response-{args.loop}.png")
        with progress_bar(f"measuring {args.loop}") as progress:
            found = fly_measurement(
                args.loop,
                cut=args.cut,
                scenario=setup,
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
    result = pick(found, "vehicle loop cut injection") | {
        "periods": found.measured.periods,
        "bandwidth": found.margins.bandwidth,
        "rows": found.rows(),
    }
    print_result(args, result, _print_measurement, found, files=outputs.files)
    return ExitCode.DONE


def _print_measurement(found: "Measurement") -> None:
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
