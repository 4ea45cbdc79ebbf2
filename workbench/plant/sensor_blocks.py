"""Sensors for the description of a data sheet: usual numbers, and the elements that use them."""

from dataclasses import dataclass

from workbench.common.errors import unknown_name


@dataclass(frozen=True)
class SensorBlock:
    """A sensor of a usual kind on the base link.

    Attributes:
        kind: as in `--sensors`.
        numbers: name of a xacro property, formula, unit and label of each.
        source: of the numbers, as a clause.
        type: of Gazebo's sensor.
        pose: of the sensor in the base link.
        content: elements of the sensor besides rate and pose.
        name: of the sensor; "" for the kind.
    """

    kind: str
    numbers: tuple[tuple[str, str, str, str], ...]
    source: str
    type: str
    pose: str
    content: str
    name: str = ""

    @property
    def text(self) -> str:
        """The sensor's element."""
        name = self.name or self.kind
        return f"""\
  <gazebo reference="base_link">
    <sensor name="{name}" type="{self.type}">
      <pose>{self.pose}</pose>
      <update_rate>${{{self.kind}_rate}}</update_rate>
      <always_on>true</always_on>
{self.content}
    </sensor>
  </gazebo>"""


def _axes_element(tag: str, noise: str) -> str:
    """Return an element with the same noise of three axes."""
    axes = "\n".join(
        f'          <{axis}><noise type="gaussian"><stddev>${{{noise}}}</stddev></noise></{axis}>'
        for axis in "xyz"
    )
    return f"        <{tag}>\n{axes}\n        </{tag}>"


def _scan_element(samples: str, angles: tuple[str, str], layers: str = "") -> str:
    """Return the horizontal scan of a lidar, and its layers."""
    low, high = angles
    return f"""\
        <scan>
          <horizontal>
            <samples>{samples}</samples>
            <min_angle>{low}</min_angle>
            <max_angle>{high}</max_angle>
          </horizontal>{layers}
        </scan>"""


def _range_element(kind: str) -> str:
    """Return limits and noise of the distances of a lidar."""
    return f"""\
        <range><min>${{{kind}_near}}</min><max>${{{kind}_far}}</max></range>
        <noise><type>gaussian</type><mean>0</mean><stddev>${{{kind}_noise}}</stddev></noise>"""


_LIDAR_LAYERS_TEMPLATE = """
          <vertical>
            <samples>${lidar_layers}</samples>
            <min_angle>${-lidar_elevation}</min_angle>
            <max_angle>${lidar_elevation}</max_angle>
          </vertical>"""
SENSOR_BLOCKS = (
    SensorBlock(
        "imu",
        (
            ("imu_rate", "200", "Hz", "samples of the IMU"),
            ("gyro_noise", "0.002", "rad/s", "noise of a sample of the gyro"),
            ("accelerometer_noise", "0.03", "m/s²", "noise of a sample of the accelerometer"),
        ),
        "usual for a flight controller's IMU",
        "imu",
        "0 0 0 0 0 0",
        "      <imu>\n"
        + _axes_element("angular_velocity", "gyro_noise")
        + "\n"
        + _axes_element("linear_acceleration", "accelerometer_noise")
        + "\n      </imu>",
    ),
    SensorBlock(
        "gps",
        (("gps_rate", "10", "Hz", "samples of the GPS"),),
        "usual; without noise, which SDF states in metres and gz-sensors applies in degrees",
        "navsat",
        "0 0 ${body_height/2 + 0.02} 0 0 0",
        "      <topic>gps</topic>",
    ),
    SensorBlock(
        "barometer",
        (
            ("barometer_rate", "50", "Hz", "samples of the barometer"),
            ("barometer_noise", "2", "Pa", "noise of a sample"),
        ),
        "usual for a flight controller's barometer",
        "air_pressure",
        "0 0 0 0 0 0",
        '      <air_pressure><pressure><noise type="gaussian">'
        "<stddev>${barometer_noise}</stddev></noise></pressure></air_pressure>",
    ),
    SensorBlock(
        "magnetometer",
        (
            ("magnetometer_rate", "50", "Hz", "samples of the magnetometer"),
            ("magnetometer_noise", "5e-7", "T", "noise of a sample"),
        ),
        "usual for a flight controller's magnetometer",
        "magnetometer",
        "0 0 0 0 0 0",
        _axes_element("magnetometer", "magnetometer_noise").replace("        <", "      <", 1),
    ),
    SensorBlock(
        "range_finder",
        (
            ("range_finder_rate", "50", "Hz", "samples of the range finder, which looks down"),
            ("range_finder_near", "0.05", "m", "its shortest distance"),
            ("range_finder_far", "20", "m", "its longest distance"),
            ("range_finder_noise", "0.01", "m", "noise of a sample"),
        ),
        "usual for a range finder with a laser",
        "gpu_lidar",
        "0 0 ${-body_height/2 - 0.005} 0 ${pi/2} 0",
        f"      <lidar>\n{_scan_element('1', ('0', '0'))}\n{_range_element('range_finder')}\n    "
        "  </lidar>",
    ),
    SensorBlock(
        "lidar",
        (
            ("lidar_rate", "10", "Hz", "scans of the lidar, on top"),
            ("lidar_samples", "360", "1", "rays of a turn"),
            ("lidar_layers", "16", "1", "layers"),
            ("lidar_elevation", "15*pi/180", "rad", "of the highest layer"),
            ("lidar_near", "0.1", "m", "its shortest distance"),
            ("lidar_far", "30", "m", "its longest distance"),
            ("lidar_noise", "0.01", "m", "noise of a ray"),
            (
                "lidar_z",
                "body_height/2 + 0.02*diameter + 0.02 + 0.27*(arm + diameter/2)",
                "m",
                "its height, above which the lowest layer passes over the propellers",
            ),
        ),
        "usual for a small lidar",
        "gpu_lidar",
        "0 0 ${lidar_z} 0 0 0",
        "      <lidar>\n"
        + _scan_element(
            "${lidar_samples}", ("${-pi}", "${pi - 2*pi/lidar_samples}"), _LIDAR_LAYERS_TEMPLATE
        )
        + f"\n{_range_element('lidar')}\n      </lidar>",
    ),
    SensorBlock(
        "depth_camera",
        (
            ("depth_camera_rate", "30", "Hz", "pictures of the depth camera, on the nose"),
            ("depth_camera_columns", "320", "1", "columns of a picture"),
            ("depth_camera_rows", "240", "1", "rows of a picture"),
            ("depth_camera_fov", "pi/3", "rad", "horizontal field of view"),
        ),
        "usual for a small depth camera",
        "rgbd_camera",
        "${body_side/2 + 0.02} 0 0 0 0 0",
        """\
      <camera>
        <horizontal_fov>${depth_camera_fov}</horizontal_fov>
        <image>
          <width>${depth_camera_columns}</width>
          <height>${depth_camera_rows}</height>
          <format>R8G8B8</format>
        </image>
        <clip><near>0.1</near><far>10</far></clip>
      </camera>""",
        "camera",
    ),
)
"""The usual sensors, by kind. They have no mass of their own: the mass of the data sheet is
all-up."""
ALL_SENSOR_KINDS, NO_SENSOR_KINDS = "all", "none"


def sensor_blocks(names: list[str]) -> tuple[SensorBlock, ...]:
    """Return the sensors of kinds, or all of them.

    Raises:
        WorkbenchError: if a kind is unknown.
    """
    known = [*(each.kind for each in SENSOR_BLOCKS), ALL_SENSOR_KINDS, NO_SENSOR_KINDS]
    for name in names:
        if name not in known:
            raise unknown_name("kind of a sensor", name, known)
    return tuple(each for each in SENSOR_BLOCKS if each.kind in names or ALL_SENSOR_KINDS in names)
