"""Loop points and loops of a cascade from position to angular acceleration, for several laws.

Attitude errors are the tilt errors about x and y of T and the heading or yaw-rate error about z.
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
"""Index of the first of the three points of each stage."""

Names = tuple[str, ...]


def cascade_loops(
    *, level: Names, climb: Names, tilt: Names, turn: Names, place: tuple[str, str], about_z: str
) -> tuple[Loop, ...]:
    """Return the loops of such a cascade.

    Args:
        level: names of the gains of the velocity loops x and y.
        climb: those of the velocity loop z.
        tilt: those of roll and pitch.
        turn: those of the loop about z.
        place: that of the position loops x and y, and that of z.
        about_z: name of the loop about z.
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
