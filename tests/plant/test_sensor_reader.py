"""Oracle: the elements as written; meaning and defaults are those of the SDF specification."""

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import read_xml
from workbench.plant.model import DeclaredSensor, Link, Model, NamedFrame
from workbench.plant.remarks import Remarks
from workbench.plant.sensor_reader import read_sensors
from workbench.plant.sensors import (
    NO_NOISE,
    Barometer,
    DepthCamera,
    Gps,
    Imu,
    Lidar,
    Magnetometer,
    Noise,
    RangeFinder,
    ScanAxis,
)

QUARTER = 1.5707963267948966
NOISE = "<mean>0.1</mean>\n<stddev>0.2</stddev>\n"
BIASED = NOISE + "<bias_mean>0.3</bias_mean>\n<bias_stddev>0.4</bias_stddev>\n"
SCAN = (
    "<scan>\n<horizontal>\n<samples>1080</samples>\n<resolution>1</resolution>\n"
    "<min_angle>-2.35</min_angle>\n<max_angle>2.34</max_angle>\n</horizontal>\n</scan>\n"
)
RANGE = "<range>\n<min>0.1</min>\n<max>30</max>\n<resolution>0.01</resolution>\n</range>\n"
CAMERA = (
    "<camera>\n<horizontal_fov>1.274</horizontal_fov>\n<image>\n<width>640</width>\n"
    "<height>480</height>\n</image>\n<clip>\n<near>0.2</near>\n<far>19.1</far>\n</clip>\n</camera>\n"
)


def sensor(kind, body="", name="eye", rate="<update_rate>50</update_rate>") -> str:
    return f'<sensor name="{name}" type="{kind}">\n{rate}\n{body}</sensor>\n'


@pytest.fixture
def read(tmp_path):
    """Read sensors, each on the link arm, which is 0.1 m in front of the base and looks left."""

    def read_text(text, remarks=None, links=("arm",) * 9, p_LS=(0.02, 0.0, 0.03), frames=()):
        path = tmp_path / "drone.sdf"
        path.write_text(f"<link>\n{text}</link>")
        X_MB = RigidTransform(RollPitchYaw(0.0, 0.3, 0.0), [0.0, 0.0, 5.0])
        X_BL = RigidTransform(RollPitchYaw(0.0, 0.0, QUARTER), [0.1, 0.0, 0.0])
        return read_sensors(
            Model(
                source=path,
                name="drone",
                links=(
                    Link("base", X_MB, None, (), ()),
                    Link("arm", X_MB @ X_BL, None, (), ()),
                    Link("leg", X_MB, None, (), ()),
                ),
                joints=(),
                frames=frames,
                sensors=tuple(
                    DeclaredSensor(link, RigidTransform(p_LS), element)
                    for link, element in zip(links, read_xml(path), strict=False)
                ),
                plugins=(),
            ),
            "base",
            remarks or Remarks(),
        )

    return read_text


def fault(read, text) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(text)
    said = str(caught.value)
    assert "drone.sdf:" in said
    assert "\n" not in said
    return said


def test_the_pose_is_in_the_body_frame(read):
    (imu,) = read(sensor("imu"))
    assert imu.p_BS == pytest.approx((0.1, 0.02, 0.03), abs=1e-12)
    flat = [value for row in imu.R_BS for value in row]
    assert flat == pytest.approx([0, -1, 0, 1, 0, 0, 0, 0, 1], abs=1e-12)


def test_name_type_link_and_rate_are_as_declared(read):
    (found,) = read(sensor("navsat", name="gnss"))
    assert (found.name, found.type, found.link, found.rate) == ("gnss", "navsat", "arm", 50.0)


@pytest.mark.parametrize("tag", ["gz_frame_id", "ignition_frame_id", "frame_id"])
def test_the_frame_is_the_links_unless_the_file_asks_for_another(read, tag):
    text = sensor("imu") + sensor("imu", f"<{tag}>optical</{tag}>", name="b")
    plain, labelled = read(text, p_LS=(0.0, 0.0, 0.0))
    assert (plain.frame, labelled.frame) == ("arm", "optical")
    assert read(text)[1].frame == "optical"


@pytest.mark.parametrize(
    ("name", "frame"),
    [
        ("eye", "eye"),
        ("leg", "leg_sensor"),
        ("world", "world_sensor"),
        ("mast", "mast_sensor"),
    ],
)
def test_beside_its_link_a_sensor_has_a_frame_of_its_own(read, name, frame):
    mast = NamedFrame("mast", "leg", RigidTransform())
    (found,) = read(sensor("imu", name=name), frames=(mast,))
    assert found.frame == frame


def test_a_sensor_that_is_turned_on_its_link_has_one_too(read):
    turned = RigidTransform(RollPitchYaw(0.0, 0.0, 0.1), [0.0, 0.0, 0.0])
    (found,) = read(sensor("imu"), p_LS=turned)
    assert found.frame == "eye"


def test_frames_of_sensors_are_told_apart(read):
    first, second = read(sensor("imu", name="leg") + sensor("imu", name="leg_sensor"))
    assert (first.frame, second.frame) == ("leg_sensor", "leg_sensor_sensor")


def test_without_a_rate_it_is_each_step_as_in_gazebo(read):
    remarks = Remarks()
    (imu,) = read(sensor("imu", rate=""), remarks)
    assert imu.rate == 0.0
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("assumed", "sensor 'eye'")


@pytest.mark.parametrize("kind", ["camera", "altimeter", "contact", "", "IMU"])
def test_other_types_are_listed_with_their_link(read, kind):
    remarks = Remarks()
    assert read(sensor(kind, rate="<update_rate>often</update_rate>"), remarks) == ()
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("ignored", "sensor 'eye'")
    assert f"type {kind} on link 'arm'" in remark.text


def test_a_sensor_whose_link_is_gone_is_listed(read):
    remarks = Remarks()
    assert read(sensor("imu"), remarks, links=["wing"]) == ()
    assert "'wing', which is not there" in remarks.found[0].text


def test_second_sensors_of_a_name_are_told_apart(read):
    found = read(sensor("imu") * 4, links=["arm", "leg", "leg", "leg"])
    assert [imu.name for imu in found] == ["eye", "leg/eye", "leg/eye_2", "leg/eye_3"]


def test_a_sensor_without_a_name_has_that_of_its_type(read):
    assert read('<sensor type="imu"><update_rate>1</update_rate></sensor>')[0].name == "imu"


@pytest.mark.parametrize("kind", ["gaussian", "gaussian_quantized", "GAUSSIAN"])
def test_an_imu_has_noise_along_each_axis(read, kind):
    noise = f'<noise type="{kind}">\n{BIASED}</noise>\n'
    (imu,) = read(
        sensor(
            "imu",
            f"<imu><angular_velocity><y>{noise}</y></angular_velocity>"
            f"<linear_acceleration><z>{noise}</z></linear_acceleration>"
            "<orientation_reference_frame><localization>NED</localization>"
            "</orientation_reference_frame></imu>",
        )
    )
    assert isinstance(imu, Imu)
    assert imu.angular_velocity == (NO_NOISE, Noise(0.1, 0.2, 0.3, 0.4), NO_NOISE)
    assert imu.linear_acceleration == (NO_NOISE, NO_NOISE, Noise(0.1, 0.2, 0.3, 0.4))


@pytest.mark.parametrize("opening", ["<noise><type>gaussian</type>", '<noise type="gaussian">'])
def test_an_old_imu_has_one_noise_for_all_axes(read, opening):
    rate, accel = f"<rate>{BIASED}</rate>", "<accel><stddev>0.7</stddev></accel>"
    (imu,) = read(sensor("imu", f"<imu>{opening}{rate}{accel}</noise></imu>"))
    assert imu.angular_velocity == (Noise(0.1, 0.2, 0.3, 0.4),) * 3
    assert imu.linear_acceleration == (Noise(0.0, 0.7),) * 3


def test_a_silent_imu_is_quiet_and_without_remark(read):
    remarks = Remarks()
    (imu,) = read(sensor("imu"), remarks)
    assert imu.angular_velocity == imu.linear_acceleration == (NO_NOISE, NO_NOISE, NO_NOISE)
    assert remarks.found == []


@pytest.mark.parametrize(
    ("attribute", "noise", "kind"),
    [
        ('type="none"', NO_NOISE, None),
        ('type="pink"', NO_NOISE, "ignored"),
        ("", Noise(0.1, 0.2), "assumed"),
    ],
)
def test_noise_of_other_types(read, attribute, noise, kind):
    remarks = Remarks()
    text = (
        f"<imu><angular_velocity><x><noise {attribute}>{NOISE}</noise></x></angular_velocity></imu>"
    )
    (imu,) = read(sensor("imu", text), remarks)
    assert imu.angular_velocity[0] == noise
    assert [remark.kind for remark in remarks.found] == ([kind] if kind else [])


DRIFT = "<dynamic_bias_stddev>0.5</dynamic_bias_stddev>\n"
TIME = "<dynamic_bias_correlation_time>400</dynamic_bias_correlation_time>\n"


def test_noise_has_a_drift_and_a_precision(read):
    remarks = Remarks()
    noise = f'<noise type="gaussian">{BIASED}{DRIFT}{TIME}<precision>0.25</precision></noise>'
    (imu,) = read(
        sensor("imu", f"<imu><angular_velocity><x>{noise}</x></angular_velocity></imu>"), remarks
    )
    assert imu.angular_velocity[0] == Noise(0.1, 0.2, 0.3, 0.4, 0.5, 400.0, 0.25)
    assert remarks.found == []


def test_a_drift_without_a_time_is_listed_once(read):
    remarks = Remarks()
    axes = "".join(f'<{axis}><noise type="gaussian">{DRIFT}</noise></{axis}>' for axis in "xyz")
    read(sensor("imu", f"<imu><angular_velocity>{axes}</angular_velocity></imu>"), remarks)
    (remark,) = remarks.found
    assert remark.kind == "ignored"
    assert "no drift" in remark.text


@pytest.mark.parametrize("kind", ["lidar", "depth"])
def test_rays_and_pixels_have_a_bias_and_no_drift(read, kind):
    remarks = Remarks()
    noise = f"<noise><type>gaussian</type>{BIASED}{DRIFT}{TIME}</noise>"
    bodies = {
        "lidar": f"<lidar>{SCAN}{RANGE}{noise}</lidar>",
        "depth": CAMERA.replace("</camera>", f"{noise}</camera>"),
    }
    (found,) = read(sensor(kind, bodies[kind]), remarks)
    assert found.noise == Noise(0.1, 0.2, 0.3, 0.4)
    assert [remark.kind for remark in remarks.found] == ["ignored"]


@pytest.mark.parametrize(
    ("kind", "tag"), [("gps", "gps"), ("navsat", "navsat"), ("navsat", "gps"), ("gps", "navsat")]
)
def test_satellite_navigation_has_four_noises(read, kind, tag):
    def noise(stddev):
        return f'<noise type="gaussian"><stddev>{stddev}</stddev></noise>'

    (gps,) = read(
        sensor(
            kind,
            f"<{tag}><position_sensing><horizontal>{noise(1)}</horizontal>"
            f"<vertical>{noise(2)}</vertical></position_sensing>"
            f"<velocity_sensing><horizontal>{noise(3)}</horizontal>"
            f"<vertical>{noise(4)}</vertical></velocity_sensing></{tag}>",
        )
    )
    assert isinstance(gps, Gps)
    assert gps.horizontal_position == Noise(stddev=1.0)
    assert gps.vertical_position == Noise(stddev=2.0)
    assert gps.horizontal_velocity == Noise(stddev=3.0)
    assert gps.vertical_velocity == Noise(stddev=4.0)


@pytest.mark.parametrize("kind", ["lidar", "ray", "gpu_lidar", "gpu_ray"])
@pytest.mark.parametrize("tag", ["lidar", "ray"])
def test_a_lidar_has_rays_ranges_and_noise(read, kind, tag):
    noise = f"<noise><type>gaussian</type>{NOISE}</noise>"
    (lidar,) = read(sensor(kind, f"<{tag}>{SCAN}{RANGE}{noise}</{tag}>"))
    assert isinstance(lidar, Lidar)
    assert lidar.type == kind
    assert lidar.horizontal == ScanAxis(1080, -2.35, 2.34)
    assert lidar.vertical == ScanAxis(1, 0.0, 0.0)
    assert (lidar.min_range, lidar.max_range, lidar.resolution) == (0.1, 30.0, 0.01)
    assert lidar.noise == Noise(0.1, 0.2)


@pytest.mark.parametrize(
    ("resolution", "samples"), [("2", 2160), ("0.5", 540), ("0.1", 108), ("0.002", 2)]
)
def test_resolution_multiplies_rays(read, resolution, samples):
    scan = SCAN.replace("<resolution>1<", f"<resolution>{resolution}<")
    (lidar,) = read(sensor("lidar", f"<lidar>{scan}{RANGE}</lidar>"))
    assert lidar.horizontal.samples == samples


def test_a_lidar_may_have_rows(read):
    rows = (
        "<vertical><samples>16</samples><min_angle>-0.26</min_angle><max_angle>0.26</max_angle>"
        "</vertical></scan>"
    )
    (lidar,) = read(sensor("lidar", f"<lidar>{SCAN.replace('</scan>', rows)}{RANGE}</lidar>"))
    assert lidar.vertical == ScanAxis(16, -0.26, 0.26)


ONE = SCAN.replace("1080", "1").replace("-2.35", "0").replace("2.34", "0")


@pytest.mark.parametrize("kind", ["lidar", "ray", "gpu_lidar", "gpu_ray"])
def test_a_lidar_of_a_single_ray_is_a_range_finder(read, kind):
    noise = f"<noise><type>gaussian</type>{NOISE}</noise>"
    (found,) = read(sensor(kind, f"<lidar>{ONE}{RANGE}{noise}</lidar>"))
    assert isinstance(found, RangeFinder)
    assert (found.kind, found.type) == ("range_finder", kind)
    assert (found.min_range, found.max_range, found.resolution) == (0.1, 30.0, 0.01)
    assert found.noise == Noise(0.1, 0.2)


def test_a_sonar_is_a_range_finder_without_its_cone(read):
    remarks = Remarks()
    cone = "<sonar>\n<min>0.02</min>\n<max>5</max>\n<radius>1.3</radius>\n</sonar>"
    (found,) = read(sensor("sonar", cone), remarks)
    assert isinstance(found, RangeFinder)
    assert (found.min_range, found.max_range, found.noise) == (0.02, 5.0, NO_NOISE)
    (remark,) = remarks.found
    assert (remark.kind, "cone" in remark.text) == ("assumed", True)


@pytest.mark.parametrize(
    ("reference", "altitude"),
    [
        ("", None),
        ("<reference_altitude>0</reference_altitude>", 0.0),
        ("<reference_altitude>123.5</reference_altitude>", 123.5),
    ],
)
def test_a_barometer_has_noise_and_maybe_a_reference_altitude(read, reference, altitude):
    noise = f'<pressure><noise type="gaussian">{BIASED}</noise></pressure>'
    (found,) = read(sensor("air_pressure", f"<air_pressure>{reference}{noise}</air_pressure>"))
    assert isinstance(found, Barometer)
    assert (found.kind, found.reference_altitude) == ("barometer", altitude)
    assert found.noise == Noise(0.1, 0.2, 0.3, 0.4)


def field_noise(stddev) -> str:
    noise = f'<noise type="gaussian"><mean>0.5</mean><stddev>{stddev}</stddev></noise>'
    return f"<magnetometer><x/><y>{noise}</y><z>{noise}</z></magnetometer>"


def test_a_magnetometer_has_noise_along_each_axis(read):
    remarks = Remarks()
    found, bare = read(
        sensor("magnetometer", field_noise(4e-7)) + sensor("magnetometer", name="b"), remarks
    )
    assert isinstance(found, Magnetometer)
    assert (found.kind, found.rate) == ("magnetometer", 50.0)
    assert found.magnetic_field == (NO_NOISE, Noise(0.5, 4e-7), Noise(0.5, 4e-7))
    assert bare.magnetic_field == (NO_NOISE,) * 3
    assert remarks.found == []


def test_a_magnetometers_noise_as_strong_as_the_earths_field_is_in_gauss(read):
    remarks = Remarks()
    (found,) = read(sensor("magnetometer", field_noise(3e-3)), remarks)
    assert found.magnetic_field == (NO_NOISE, *[Noise(5e-5, pytest.approx(3e-7))] * 2)
    (remark,) = remarks.found
    assert (remark.kind, "gauss" in remark.text) == ("repaired", True)


def test_kinds_are_named_alike_for_all_types(read):
    bodies = {
        "imu": "",
        "gps": "",
        "navsat": "",
        "air_pressure": "",
        "magnetometer": "",
        "sonar": "",
        "ray": f"<ray>{SCAN}{RANGE}</ray>",
        "lidar": f"<lidar>{ONE}{RANGE}</lidar>",
        "rgbd": "",
    }
    found = read("".join(sensor(kind, body) for kind, body in bodies.items()))
    assert [each.kind for each in found] == [
        "imu",
        "gps",
        "gps",
        "barometer",
        "magnetometer",
        "range_finder",
        "lidar",
        "range_finder",
        "depth_camera",
    ]


@pytest.mark.parametrize("kind", ["depth", "depth_camera", "rgbd", "rgbd_camera"])
def test_a_depth_camera_has_picture_and_clip(read, kind):
    noise = f"<noise><type>gaussian</type>{NOISE}</noise></camera>"
    (camera,) = read(sensor(kind, CAMERA.replace("</camera>", noise)))
    assert isinstance(camera, DepthCamera)
    assert (camera.width, camera.height, camera.horizontal_fov) == (640, 480, 1.274)
    assert (camera.near, camera.far) == (0.2, 19.1)
    assert camera.noise == Noise(0.1, 0.2)


def test_a_depth_cameras_own_clip_goes_first(read):
    own = "<depth_camera><clip><far>8</far></clip></depth_camera></camera>"
    (camera,) = read(sensor("depth", CAMERA.replace("</camera>", own)))
    assert (camera.near, camera.far) == (0.2, 8.0)


@pytest.mark.parametrize("fov", [0.1, 6.28])
def test_a_depth_camera_may_look_narrowly_or_all_around(read, fov):
    assert read(sensor("depth", CAMERA.replace("1.274", str(fov))))[0].horizontal_fov == fov


def test_a_bare_depth_camera_has_sdfs_defaults(read):
    remarks = Remarks()
    (camera,) = read(sensor("depth"), remarks)
    assert (camera.width, camera.height, camera.horizontal_fov) == (320, 240, 1.047)
    assert (camera.near, camera.far) == (0.1, 100.0)
    assert [remark.kind for remark in remarks.found] == ["assumed"]


LIDAR = f"<lidar>\n{SCAN}{RANGE}</lidar>\n"
SONAR = "<sonar>\n<min>0.02</min>\n<max>5</max>\n</sonar>\n"
PRESSURE = (
    "<air_pressure>\n<reference_altitude>3</reference_altitude>\n"
    f"<pressure>\n<noise type='gaussian'>\n<stddev>0.2</stddev>\n{DRIFT}{TIME}"
    "<precision>0.7</precision>\n</noise>\n</pressure>\n</air_pressure>\n"
)


@pytest.mark.parametrize(
    ("kind", "body", "old", "new"),
    [
        ("imu", "", "50", "-1"),
        ("imu", "", "50", "nan"),
        ("imu", "", "50", "inf"),
        ("imu", "", "50", "1e7"),
        ("imu", "", "50", ""),
        ("lidar", LIDAR, "1080", "0"),
        ("lidar", LIDAR, "1080", "-5"),
        ("lidar", LIDAR, "1080", "0.5"),
        ("lidar", LIDAR, "1080", "1000001"),
        ("lidar", LIDAR, "1080", "many"),
        ("lidar", LIDAR, "<resolution>1<", "<resolution>0<"),
        ("lidar", LIDAR, "<resolution>1<", "<resolution>1e6<"),
        ("lidar", LIDAR, "-2.35", "2.35"),
        ("lidar", LIDAR, "-2.35", "nan"),
        ("lidar", LIDAR, "<max>30", "<max>0.1"),
        ("lidar", LIDAR, "<max>30", "<max>inf"),
        ("lidar", LIDAR, "<min>0.1", "<min>-0.1"),
        ("lidar", LIDAR, "0.01", "-0.01"),
        ("lidar", LIDAR, RANGE, ""),
        ("lidar", LIDAR, "<max>30</max>", ""),
        ("lidar", LIDAR, SCAN, ""),
        ("lidar", LIDAR, RANGE, RANGE + "<noise><stddev>-1</stddev></noise>"),
        ("sonar", SONAR, "0.02", "-1"),
        ("sonar", SONAR, "0.02", "5"),
        ("sonar", SONAR, "<max>5", "<max>far"),
        ("air_pressure", PRESSURE, ">3<", ">high<"),
        ("air_pressure", PRESSURE, ">0.2<", ">-0.2<"),
        ("air_pressure", PRESSURE, ">0.5<", ">-0.5<"),
        ("air_pressure", PRESSURE, ">400<", ">-400<"),
        ("air_pressure", PRESSURE, ">0.7<", ">nan<"),
        ("depth", CAMERA, "1.274", "0"),
        ("depth", CAMERA, "1.274", "-1"),
        ("depth", CAMERA, "1.274", "6.2832"),
        ("depth", CAMERA, "1.274", "wide"),
        ("depth", CAMERA, "640", "0"),
        ("depth", CAMERA, "480", "1e5"),
        ("depth", CAMERA, "0.2", "19.1"),
        ("depth", CAMERA, "0.2", "-0.2"),
        ("depth", CAMERA, "0.2", "1e308"),
    ],
)
def test_what_cannot_be_is_named_with_its_line(read, kind, body, old, new):
    good = sensor(kind, body)
    assert len(read(good)) == 1
    assert old in good
    assert "sensor 'eye'" in fault(read, good.replace(old, new, 1))


def test_a_lidar_that_leaves_all_to_a_plugin_is_not_used(read):
    remarks = Remarks()
    assert read(sensor("ray", '<plugin filename="libscan.so"/>'), remarks) == ()
    assert [remark.kind for remark in remarks.found] == ["ignored"]


def test_a_lidar_needs_a_horizontal_scan(read):
    assert "<horizontal>" in fault(read, sensor("ray", f"<ray>{RANGE}</ray>"))


def test_a_lidar_may_leave_out_what_sdf_has_a_default_for(read):
    text = LIDAR.replace("<min>0.1</min>", "").replace("<samples>1080</samples>", "")
    (lidar,) = read(sensor("lidar", text.replace("<resolution>0.01</resolution>", "")))
    assert lidar.horizontal.samples == 640
    assert (lidar.min_range, lidar.resolution) == (0.0, 0.0)


def test_the_line_is_that_of_the_number(read):
    assert "drone.sdf:9: " in fault(read, sensor("lidar", LIDAR).replace("-2.35", "left"))


def test_more_than_a_million_rays_in_all_are_refused(read):
    rows = "<vertical><samples>926</samples></vertical></scan>"
    good = sensor("lidar", LIDAR.replace("</scan>", rows.replace("926", "925")))
    assert read(good)[0].vertical.samples == 925
    assert "1080 x 926" in fault(read, sensor("lidar", LIDAR.replace("</scan>", rows)))


def test_more_sensors_than_any_drone_has_are_refused(read):
    with pytest.raises(WorkbenchError, match="1001 sensors"):
        read(sensor("imu") * 1001, links=["arm"] * 1001)
