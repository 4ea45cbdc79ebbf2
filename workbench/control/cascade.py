"""Loop points and loops of a cascade from position to angular acceleration.

Several laws have it. Attitude means the errors about x and y of T, and that of the turn about z.
"""

from workbench.control.controller import Loop

CASCADE_POINTS = {
    f"{name}_{axis}{after}": unit
    for name, after, unit in (
        ("position", "_error", "m"),
        ("velocity", "_error", "m/s"),
        ("acceleration", "", "m/s^2"),
        ("attitude", "_error", "1"),
        ("angular_acceleration", "", "rad/s^2"),
    )
    for axis in "xyz"
}
POSITION, VELOCITY, ACCELERATION, ATTITUDE, ANGULAR_ACCELERATION = range(0, 15, 3)
"""Where the three points of each stage begin."""

Names = tuple[str, ...]


def cascade_loops(
    *, level: Names, climb: Names, tilt: Names, turn: Names, place: tuple[str, str], about_z: str
) -> tuple[Loop, ...]:
    """Return the loops of such a cascade.

    Args:
        level: names of the gains of the velocities x and y.
        climb: of the velocity z.
        tilt: of roll and pitch.
        turn: of the turn about z.
        place: of the position x and y, and of z.
        about_z: name of the loop of that turn.
    """
    gains_of_velocity = {"x": level, "y": level, "z": climb}
    gains_of_place = {"x": place[:1], "y": place[:1], "z": place[1:]}
    return (
        *(
            Loop(f"velocity_{k}", f"velocity_{k}_error", f"acceleration_{k}", axis=k, gains=gains)
            for k, gains in gains_of_velocity.items()
        ),
        *(
            Loop(name, f"attitude_{k}_error", f"angular_acceleration_{k}", axis=axis, gains=gains)
            for name, k, axis, gains in (
                ("roll", "x", "y", tilt),
                ("pitch", "y", "x", tilt),
                (about_z, "z", "yaw", turn),
            )
        ),
        *(
            Loop(
                f"position_{k}",
                f"position_{k}_error",
                f"position_{k}_error",
                hold=True,
                axis=k,
                gains=gains,
            )
            for k, gains in gains_of_place.items()
        ),
    )
