"""How many rotors a description has."""

from workbench import load_vehicle
from workbench.commands.options import add_command


def add_parser(commands):
    """Add the command."""
    parser = add_command(
        commands,
        "rotor-count",
        "Print how many rotors a description has.",
        "workbench rotor-count drone.xacro",
        run,
    )
    parser.add_argument("model", help="a description: xacro, URDF, SDF or MJCF")


def run(args):
    """Print the number, and return the exit code."""
    print(len(load_vehicle(args.model).rotors))
    return 0
