"""`workbench fly`: fly a scenario, or a table of rotor commands from its start."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_scenario, with_sensors
from workbench.commands.flight_report import FlightOutcome, report_flight
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_output_options,
    add_sensor_options,
    add_vehicle_options,
)
from workbench.commands.outputs import Outputs, make_folder_of
from workbench.commands.printing import (
    pick,
    print_message,
    print_result,
    print_table,
    print_written_files,
)
from workbench.commands.progress import progress_bar
from workbench.commands.stopping import stop_event_on_signal
from workbench.common.errors import FlightBrokenError, WorkbenchError

FILE_WATCH_PERIOD_S = 0.1
"""Period between checks of a watched flight [s]."""

if TYPE_CHECKING:
    from workbench.scenario.scenario import Scenario
    from workbench.session.session import Session


def _print_shipped(args: argparse.Namespace) -> None:
    """Print the shipped scenarios and worlds with their titles."""
    from workbench.common.resources import (
        find_scenario,
        find_world,
        list_scenarios,
        list_worlds,
        worlds_dir,
    )
    from workbench.plant.worlds.reading import read_world
    from workbench.scenario.scenario_file import load_scenario

    scenarios = {name: load_scenario(find_scenario(name)) for name in list_scenarios()}
    packages = {"worlds": str(worlds_dir())}
    worlds = {name: read_world(find_world(name), packages) for name in list_worlds()}

    def show() -> None:
        print("scenarios")
        rows = [
            (f"  {name}", f"{each.duration:g} s", each.title) for name, each in scenarios.items()
        ]
        print_table(rows, left=(0, 2))
        print("\nworlds, for --world")
        print_table([(f"  {name}", each.title) for name, each in worlds.items()], left=(0, 1))

    result = {
        "scenarios": [
            {"name": name, **pick(each, "title duration")} for name, each in scenarios.items()
        ],
        "worlds": [{"name": name, "title": world.title} for name, world in worlds.items()],
    }
    print_result(args, result, show)


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fly",
        "Fly a scenario, print a summary, and write a log and an overview picture.",
        "workbench fly take-off-and-land --csv states.csv --set take_off_speed=0.5",
        run,
    )
    parser.usage = "%(prog)s SCENARIO [options]"  # options with several values would swallow it
    parser.add_argument(
        "scenario", nargs="?", metavar="SCENARIO", help="shipped scenario, or a .yaml file"
    )
    parser.add_argument(
        "--list", action="store_true", help="list the shipped scenarios and worlds and stop"
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help="fly this long instead of the scenario's time [s]",
    )
    parser.add_argument(
        "--csv", type=Path, metavar="FILE", help="log of the states (default: DIR/SCENARIO.csv)"
    )
    parser.add_argument(
        "--log",
        type=Path,
        metavar="FILE.mcap",
        help="all topics, for Foxglove, PlotJuggler and `workbench replay`",
    )
    parser.add_argument(
        "--watch",
        action="store_true",
        help="fly in real time, drawn in a browser; each time that the file of --controller is "
        "saved, it takes over in flight; Ctrl-C ends the flight",
    )
    parser.add_argument(
        "--rotor-commands",
        type=Path,
        metavar="FILE.csv",
        help="fly open loop: columns t [s] and one thrust [N] a rotor, held between rows",
    )
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE",
        help="the flight in 3-D, as one page that any browser plays, without a server",
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_sensor_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, print the summary, write log and overview."""
    from workbench.common.resources import find_scenario
    from workbench.scenario.scenario_file import load_scenario

    if args.list:
        _print_shipped(args)
        return ExitCode.DONE
    if args.scenario is None:
        raise WorkbenchError(
            "no scenario is named: name one, as in `workbench fly hover`; `workbench fly --list` "
            "lists the shipped ones"
        )
    if args.csv and args.rotor_commands and args.csv.resolve() == args.rotor_commands.resolve():
        raise WorkbenchError(f"{args.csv}: is the table that is flown: name another file for --csv")
    path = find_scenario(args.scenario)
    scenario = load_scenario(path, args.controller, args.estimator)
    scenario = with_sensors(chosen_scenario(args, scenario), args)
    scenario.sensors.keep = True
    title = scenario.title or path.stem
    if args.rotor_commands is not None:
        title = f"open loop, {args.rotor_commands.name} from the start of {path.stem}"
    if args.duration is not None:
        scenario.duration = args.duration
    with Outputs() as outputs:
        log = outputs.add(args.csv or args.output / f"{path.stem}.csv")
        plot = outputs.picture(args, f"{path.stem}.png")
        page = outputs.add(args.html) if args.html else None
        flown = _fly(scenario, path.stem, args, page)
        flown.recording.write_csv(log)
        for samples in flown.samples:
            name = samples.sensor.replace("/", "_").replace("::", "_")
            samples.write(outputs.add(args.output / f"{path.stem}-{name}{samples.suffix}"))
        for ending, record in flown.records.items():
            outputs.add(args.output / f"{path.stem}{ending}").write_bytes(record)
        if plot:
            from workbench.design.plots import write_png
            from workbench.design.plots_flight import plot_flight

            name = flown.recording.vehicle.name
            figure = plot_flight(flown.recording, f"{name}: {title}", flown.world)
            write_png(figure, plot)
            if flown.recording.estimated:
                from workbench.design.plots_estimate import plot_estimate

                figure = plot_estimate(flown.recording, f"{name}: {title}, {scenario.estimator}")
                write_png(figure, outputs.add(args.output / f"{path.stem}-estimate.png"))
    report_flight(args, title, flown, outputs.files)
    print_written_files([*outputs.files, *([args.log] if args.log and not flown.log_said else [])])
    if flown.broken:
        print_message(f"{flown.broken}; what was flown until then is in the log")
        return ExitCode.NOT_AS_DEMANDED
    if flown.ended:
        print_message(flown.ended)
        return ExitCode.NOT_AS_DEMANDED
    if flown.log_said:  # reported when the log was lost
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _fly(
    scenario: "Scenario", name: str, args: argparse.Namespace, page: Path | None
) -> FlightOutcome:
    """Fly closed loop, or open loop for a table; `page` is the 3-D page to write."""
    with progress_bar(f"flying {name}") as progress:
        if args.rotor_commands is not None:
            from workbench.scenario.configured import read_configured_world
            from workbench.session.open_loop import fly_open_loop

            if (
                args.set
                or args.gains
                or args.html
                or args.sensors
                or args.log
                or args.watch
                or args.estimator
                or args.controller
            ):
                raise WorkbenchError(
                    "--rotor-commands flies without controller, sensors, estimator, replay page "
                    "and topics: leave out --controller, --set, --gains, --sensors, --html, --log, "
                    "--watch and --estimator"
                )
            if unused := _without_effect(scenario):
                print_message(
                    f"the table flies alone, without what {name} has: {', '.join(unused)}"
                )
            recording = fly_open_loop(scenario, args.rotor_commands, progress)
            return FlightOutcome(recording, read_configured_world(scenario))
        broken = log_said = ""
        if args.watch:
            return _watched(scenario, args)
        if page is None:
            session, broken, log_said = _flown_session(scenario, args, progress)
        else:
            if args.log:
                raise WorkbenchError("--html and --log do not go together: leave one out")
            from workbench.design.flight_page import fly_and_film

            session = fly_and_film(scenario, dict(args.set), page, progress)
        return FlightOutcome(
            recording=session.recording(),
            world=session.world,
            sensors=() if broken else session.snapshot().sensors,
            samples=session.samples(),
            broken=broken,
            log_said=log_said,
            exchange=session.exchange,
            ended=session.ended,
            records=session.records,
        )


def _without_effect(scenario: "Scenario") -> list[str]:
    """Return the parts of a scenario without effect on a flight under a table of commands."""
    parts = {
        "a script": scenario.script,
        "a figure of eight": scenario.figure_eight,
        "sensors": scenario.sensors.use,
        f"the estimator {scenario.estimator}": scenario.is_estimated,
    }
    return [name for name, there in parts.items() if there]


def _watched(scenario: "Scenario", args: argparse.Namespace) -> FlightOutcome:
    """Fly in real time, and report the result of each edit of the file of the law."""
    from workbench.live.flight import LiveFlight
    from workbench.live.messages import Phase
    from workbench.scenario.configured import read_configured_world
    from workbench.scenario.flown_controller import flown_controller

    law = flown_controller(scenario)
    if law.shipped or args.html:
        raise WorkbenchError(
            "--watch needs a control law of your own, and does not write --html: name its file, as "
            "--controller mine.py, and leave out --html"
        )
    log_said, told = "", 0
    with (
        stop_event_on_signal() as stopped,
        LiveFlight(scenario, dict(args.set), draw=True, watch=True) as flight,
    ):
        view = flight.wait(progress=print_message)
        print_message(
            f"{law.file} flies, drawn at {view.url}: edit and save it; Ctrl-C ends the flight"
        )
        if args.log:
            make_folder_of(args.log)
            flight.keep_log(args.log).result()
        while not stopped.wait(FILE_WATCH_PERIOD_S):
            view = flight.latest()
            for said in view.remarks[told:]:
                print_message(said)
            told = len(view.remarks)
            if view.is_over:
                break
            if view.snapshot and view.snapshot.time >= scenario.duration:
                break
        if args.log:
            flight.stop_log().result()
            log_said = flight.latest().network.log_said
        if view.phase is Phase.ENDED or view.snapshot is None:
            raise WorkbenchError(view.said)
        flown = flight.flown().result()
        return FlightOutcome(
            recording=flown.recording,
            world=read_configured_world(scenario),
            sensors=view.snapshot.sensors,
            samples=flown.samples,
            broken=view.said if view.phase is Phase.BROKEN else "",
            log_said=log_said,
        )


def _flown_session(
    scenario: "Scenario", args: argparse.Namespace, progress: "Callable[[float], None]"
) -> "tuple[Session, str, str]":
    """Fly to the end, or until the flight breaks off.

    Returns:
        The session, why it broke off, and why its log did.
    """
    from workbench.session.session import Session

    logged = None
    if args.log:
        from workbench.logs.flight_log import LoggedFlight

        make_folder_of(args.log)
        logged = LoggedFlight(args.log, scenario, dict(args.set))
    session = logged.session if logged else Session(scenario, dict(args.set))
    broken = ""
    with session.programs():
        try:
            (logged or session).run(progress)
        except FlightBrokenError as error:  # the log shows the cause
            broken = str(error)
        except KeyboardInterrupt as interrupt:
            if logged:
                interrupt.add_note(f"{args.log} has the flight until then")
            raise
    return session, broken, logged.said if logged else ""
