"""The colours of Gazebo's material scripts."""

Colour = tuple[float, float, float, float]
"""Red, green, blue and opacity, 0 .. 1."""


def _opaque(red: float, green: float, blue: float) -> Colour:
    return (red, green, blue, 1.0)


GAZEBO_COLOURS: dict[str, Colour] = {
    "Gazebo/Black": _opaque(0.0, 0.0, 0.0),
    "Gazebo/FlatBlack": _opaque(0.1, 0.1, 0.1),
    "Gazebo/DarkGrey": _opaque(0.175, 0.175, 0.175),
    "Gazebo/DarkGray": _opaque(0.175, 0.175, 0.175),
    "Gazebo/Grey": _opaque(0.7, 0.7, 0.7),
    "Gazebo/Gray": _opaque(0.7, 0.7, 0.7),
    "Gazebo/White": _opaque(1.0, 1.0, 1.0),
    "Gazebo/Red": _opaque(1.0, 0.0, 0.0),
    "Gazebo/RedBright": _opaque(0.87, 0.26, 0.07),
    "Gazebo/Green": _opaque(0.0, 1.0, 0.0),
    "Gazebo/Blue": _opaque(0.0, 0.0, 1.0),
    "Gazebo/SkyBlue": _opaque(0.13, 0.44, 0.70),
    "Gazebo/Yellow": _opaque(1.0, 1.0, 0.0),
    "Gazebo/ZincYellow": _opaque(0.97, 0.95, 0.21),
    "Gazebo/DarkYellow": _opaque(0.7, 0.7, 0.0),
    "Gazebo/Orange": _opaque(1.0, 0.51, 0.05),
    "Gazebo/Gold": _opaque(0.8, 0.65, 0.12),
    "Gazebo/Purple": _opaque(1.0, 0.0, 1.0),
    "Gazebo/Indigo": _opaque(0.33, 0.0, 0.5),
    "Gazebo/Turquoise": _opaque(0.0, 1.0, 1.0),
    "Gazebo/Wood": _opaque(0.6, 0.45, 0.3),
}
"""The plain colours in Gazebo classic's gazebo.material, by name."""
