"""The colours of Gazebo's material scripts."""

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 .. 1."""


def _opaque_rgba(red: float, green: float, blue: float) -> Colour:
    return (red, green, blue, 1.0)


GAZEBO_COLOURS: dict[str, Colour] = {
    "Gazebo/Black": _opaque_rgba(0.0, 0.0, 0.0),
    "Gazebo/FlatBlack": _opaque_rgba(0.1, 0.1, 0.1),
    "Gazebo/DarkGrey": _opaque_rgba(0.175, 0.175, 0.175),
    "Gazebo/DarkGray": _opaque_rgba(0.175, 0.175, 0.175),
    "Gazebo/Grey": _opaque_rgba(0.7, 0.7, 0.7),
    "Gazebo/Gray": _opaque_rgba(0.7, 0.7, 0.7),
    "Gazebo/White": _opaque_rgba(1.0, 1.0, 1.0),
    "Gazebo/Red": _opaque_rgba(1.0, 0.0, 0.0),
    "Gazebo/RedBright": _opaque_rgba(0.87, 0.26, 0.07),
    "Gazebo/Green": _opaque_rgba(0.0, 1.0, 0.0),
    "Gazebo/Blue": _opaque_rgba(0.0, 0.0, 1.0),
    "Gazebo/SkyBlue": _opaque_rgba(0.13, 0.44, 0.70),
    "Gazebo/Yellow": _opaque_rgba(1.0, 1.0, 0.0),
    "Gazebo/ZincYellow": _opaque_rgba(0.97, 0.95, 0.21),
    "Gazebo/DarkYellow": _opaque_rgba(0.7, 0.7, 0.0),
    "Gazebo/Orange": _opaque_rgba(1.0, 0.51, 0.05),
    "Gazebo/Gold": _opaque_rgba(0.8, 0.65, 0.12),
    "Gazebo/Purple": _opaque_rgba(1.0, 0.0, 1.0),
    "Gazebo/Indigo": _opaque_rgba(0.33, 0.0, 0.5),
    "Gazebo/Turquoise": _opaque_rgba(0.0, 1.0, 1.0),
    "Gazebo/Wood": _opaque_rgba(0.6, 0.45, 0.3),
}
"""The plain colours in Gazebo classic's gazebo.material, by name."""
