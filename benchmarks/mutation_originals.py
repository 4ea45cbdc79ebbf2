"""The files that `mutated_files.py` mutates: those of the repository, and made up ones."""

import gzip
import random
import shutil
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import trimesh
import xacro
from PIL import Image
from trimesh.exchange.obj import export_obj

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # the writers of foreign files are those of the tests

from tests.extras.autopilots.gain_files import made_up  # noqa: E402
from tests.extras.flightdata import foreign_files  # noqa: E402
from tests.plant.made_up import MJCF, SDF  # noqa: E402
from workbench.common.flight import Flight  # noqa: E402
from workbench.common.series import make_series  # noqa: E402
from workbench.control.controller_file import load_controller  # noqa: E402
from workbench.design.regress.spec_names import spec_name  # noqa: E402
from workbench.extras.autopilots.gain_files.firmware import find_firmware  # noqa: E402
from workbench.extras.flightdata.importing import write_flight  # noqa: E402

GIVEN, DRONES, MODELS = ROOT / "tests/outside/given", ROOT / "tests/drones", ROOT / "models"
STAMPS = 1_000_000 + 2000 * np.arange(200)
"""Times of the samples of logs [us]."""
RATES = 90.0 * np.sin(1e-6 * STAMPS)
"""Gyro about x [deg/s]."""
FIRMWARES = {
    "px4-parameters": ("px4", ".params"),
    "ardupilot-parameters": ("ardupilot", ".param"),
    "betaflight-settings": ("betaflight", ".txt"),
    "crazyflie-parameters": ("crazyflie", ".yaml"),
}

WORLD = """<sdf version="1.9"><world name="town">
  <spherical_coordinates><latitude_deg>47.4</latitude_deg><longitude_deg>8.5</longitude_deg>
    <elevation>488</elevation></spherical_coordinates>
  <frame name="corner"><pose>1 2 3 0.1 0.2 0.3</pose></frame>
  <model name="ground"><static>true</static><link name="link"><collision name="c"><geometry>
    <plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
  <model name="house"><static>true</static><pose relative_to="corner">4 0 0 0 0 1</pose>
    <link name="link"><collision name="c"><geometry><box><size>1 2 3</size></box></geometry>
    </collision><visual name="v"><geometry><cylinder><radius>1</radius><length>2</length>
    </cylinder></geometry><material><diffuse>1 0 0 1</diffuse></material></visual></link>
    <model name="roof"><pose>0 0 3 0 0 0</pose><link name="link"><collision name="c"><geometry>
    <sphere><radius>0.5</radius></sphere></geometry></collision></link></model></model>
  <wind><linear_velocity>1 0 0</linear_velocity></wind>
</world></sdf>"""
HULL = """<robot name="hull"><link name="base_link">
  <inertial><mass value="1.0"/><inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/>
  </inertial>
  <visual><geometry><mesh filename="{0}"/></geometry></visual>
  <collision><geometry><mesh filename="{0}" scale="0.1 0.1 0.1"/></geometry></collision>
</link></robot>"""


def write_originals(folder: Path) -> None:
    """Write the files into a folder for each kind."""
    for write in (_write_logs, _write_tables, _write_descriptions, _write_meshes, _write_yaml):
        write(lambda kind: _made(folder / kind))


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


Place = Callable[[str], Path]
"""Returns the folder of a kind."""


def _write_logs(place: Place) -> None:
    shutil.copy(GIVEN / "flight.mcap", place("log-mcap"))
    time = np.arange(0.0, 3.0, 0.02)
    names = ("imu.angular_velocity.x", "estimate.x", "rotors.speed.0", "battery.voltage")
    signals = {name: make_series(name, "1", time, np.sin(time)) for name in names}
    flight = Flight("m", Path("m"), "made", signals, "firmware", {"P": 1.0}, ("a",), 3.0)
    write_flight(flight, place("log-mcap-imported") / "m.mcap")
    for kind, write in (
        ("log-ulog", foreign_files.write_ulog),
        ("log-dataflash", foreign_files.write_dataflash),
        ("log-blackbox", foreign_files.write_blackbox),
        ("log-blackbox-head", foreign_files.write_blackbox),
        ("log-usd", foreign_files.write_usd),
    ):
        written = write(place(kind), STAMPS, RATES)
        if not kind.endswith("head"):
            packed = place("log-packed") / f"{kind}{written.suffix}.gz"
            packed.write_bytes(gzip.compress(written.read_bytes()))


def _write_tables(place: Place) -> None:
    tables = place("log-table")
    for write in (
        foreign_files.write_csv,
        foreign_files.write_states,
        foreign_files.write_nanobench,
    ):
        written = write(_made(tables / write.__name__), STAMPS, RATES)
        folder = _made(place("log-table-packed") / write.__name__)
        (folder / "a.csv.gz").write_bytes(gzip.compress(written.read_bytes()))
        for file in written.parent.glob("*.yaml"):
            shutil.copy(file, folder)
    foreign_files.write_csv(place("log-mapping"), STAMPS, RATES)
    foreign_files.write_nanobench(place("log-metadata"), STAMPS, RATES)
    (place("log-metadata") / "a_metadata.yaml").write_text(
        "row_counts: {imu: 200, motor: 190}\nfirmware_version: 2025.02\n"
        "params: {altitude_m: 0.5, name: [a, b]}\n"
    )
    (place("rotor-commands") / "rotors.csv").write_text(
        "t,f1,f2,f3,f4\n0.0,4.66,4.66,4.66,4.66\n1.0,4.80,4.80,4.80,4.80\n"
    )
    shutil.copy(GIVEN / "thrust.csv", place("thrust-curve"))


def _write_descriptions(place: Place) -> None:
    for file in DRONES.glob("*.xacro"):
        shutil.copy(file, place("xacro"))
        shutil.copy(file, place("xacro-parts"))
    for file in (*DRONES.glob("*.urdf"), *DRONES.glob("*.rotors.yaml"), *GIVEN.glob("plate.*")):
        shutil.copy(file, place("urdf"))
    for name in ("hexacopter", "tilted_quad"):
        text = xacro.process_file(str(DRONES / f"{name}.urdf.xacro")).toprettyxml()
        (place("urdf") / f"{name}.urdf").write_text(text)
    for file in GIVEN.glob("plate.*"):
        shutil.copy(file, place("rotors"))
    (place("sdf") / "frame.sdf").write_text(SDF)
    (place("mjcf") / "frame.xml").write_text(MJCF)
    (place("mjcf") / "gone.obj").write_text(export_obj(trimesh.creation.box((0.1, 0.1, 0.02))))
    (place("world-sdf") / "town.sdf").write_text(WORLD)
    shutil.copytree(MODELS / "worlds/obstacles", place("world") / "obstacles")
    for file in (*(MODELS / "worlds").glob("*.yaml"), GIVEN / "yard.yaml"):
        shutil.copy(file, place("world"))


def _write_meshes(place: Place) -> None:
    box, ball = trimesh.creation.box((1.0, 2.0, 0.5)), trimesh.creation.icosphere(1)
    with warnings.catch_warnings():  # pycollada sets the shape of an array, as NumPy < 2.5 liked
        warnings.simplefilter("ignore", DeprecationWarning)
        collada = trimesh.exchange.dae.export_collada(box)
    for kind, name, data in (
        ("mesh-text", "stl", trimesh.exchange.stl.export_stl_ascii(box)),
        ("mesh-text", "obj", export_obj(ball)),
        ("mesh-text", "off", trimesh.exchange.off.export_off(box)),
        ("mesh-text", "ply", trimesh.exchange.ply.export_ply(box, encoding="ascii")),
        ("mesh-xml", "dae", collada),
        ("mesh-binary", "stl", trimesh.exchange.stl.export_stl(ball)),
        ("mesh-binary", "ply", trimesh.exchange.ply.export_ply(ball)),
        ("mesh-binary", "glb", trimesh.exchange.gltf.export_glb(trimesh.Scene(box))),
    ):
        _write_mesh(place(kind) / name, f"mesh.{name}", data)
    files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(ball))
    folder = _write_mesh(place("mesh-text") / "gltf", "mesh.gltf", files.pop("model.gltf"))
    for name, data in files.items():
        (folder / name).write_bytes(data)
    lines = "mtllib skin.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n"
    folder = _write_mesh(place("mesh-text") / "skin", "mesh.obj", f"{lines}f 1/1 2/2 3/3\n")
    material = "newmtl skin\nKd 0.8 0.1 0.1\nmap_Kd mesh.png\n"
    (folder / "skin.mtl").write_text(material)
    Image.new("RGB", (4, 4), (200, 10, 10)).save(folder / "mesh.png")
    shutil.copytree(folder, place("mesh-binary") / "picture")
    (place("mesh-binary") / "picture/mesh.obj").rename(place("mesh-binary") / "picture/a.obj")
    (place("mesh-binary") / "picture/model.urdf").write_text(HULL.format("a.obj"))
    shutil.copytree(folder, place("mesh-text") / "material")
    (place("mesh-text") / "material/mesh.obj").write_text(lines.replace("skin.mtl", "mesh.mtl"))


def _write_mesh(folder: Path, name: str, data: str | bytes) -> Path:
    _made(folder)
    (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
    (folder / "model.urdf").write_text(HULL.format(name))
    shutil.copy(GIVEN / "plate.rotors.yaml", folder / "model.rotors.yaml")
    return folder


def _write_yaml(place: Place) -> None:
    for file in (*(MODELS / "scenarios").glob("*.yaml"), GIVEN / "flight.yaml"):
        shutil.copy(file, place("scenario") / f"{file.stem}.scenario.yaml")
    for pattern in ("*.gains.yaml", "*.xacro", "yard.yaml"):
        for file in GIVEN.glob(pattern):
            shutil.copy(file, place("scenario"))
    for file in (MODELS / "dh_drone/gains.yaml", *GIVEN.glob("*.gains.yaml")):
        shutil.copy(file, place("gains"))
    for spec in (*(MODELS / "specs").glob("*.workbench.yaml"), GIVEN / "old.spec.yaml"):
        folder = _made(place("spec") / spec.name.partition(".")[0])
        shutil.copy(spec, folder)
        baseline = spec.with_name(f"{spec_name(spec)}.baseline")
        if baseline.is_dir():
            shutil.copytree(baseline, folder / baseline.name, dirs_exist_ok=True)
        for file in (GIVEN / "palm_quad.urdf.xacro", GIVEN / "parts.xacro"):
            shutil.copy(file, folder)
    shutil.copy(GIVEN / "wishes.yaml", place("wishes"))
    for kind, (name, ending) in FIRMWARES.items():
        firmware = find_firmware(name)
        law = load_controller(firmware.laws[0])
        for seed in range(3):
            chance = random.Random(seed)
            gains = made_up.gains_of(firmware, law, chance, made_up.release_of(firmware))
            text = made_up.text_of(firmware, gains, chance)
            (place(kind) / f"{seed}{ending}").write_bytes(text.encode("utf-8", "surrogateescape"))
