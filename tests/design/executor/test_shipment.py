"""The files of a scenario, laid out where the first ones are not: the same vehicle and world."""

import dataclasses
import pickle
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import controllers_dir, models_dir
from workbench.design.executor import shipment as shipment_module
from workbench.design.executor.shipment import (
    moved_below,
    shipment,
    unpack_shipment,
    with_absolute_paths,
)
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.configured import configured_vehicle, read_configured_world
from workbench.scenario.scenario import Scenario, VehicleConfig

CUBE = "\n".join(
    ["mtllib cube.mtl", *(f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1)),
     "f 1 2 4 3", "f 5 7 8 6", "f 1 5 6 2", "f 3 4 8 7", "f 1 3 7 5", "f 2 6 8 4", ""]
)  # fmt: skip


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Return a folder of packages: a drone that includes another package's file, and a world."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    top = tmp_path / "ours"
    drone, parts = top / "drone", top / "parts"
    shutil.copytree(models_dir() / "dh_drone", drone / "urdf")
    (drone / "urdf" / "gains.yaml").write_text("gains: {kp_velocity_z: 3.0}\n")
    parts.mkdir()
    for folder in (drone, parts):
        (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>")
    (parts / "mast.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="mast"/></robot>'
    )
    (parts / "cube.obj").write_text(CUBE)
    (parts / "cube.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (parts / "unused.txt").write_text("private")
    path = drone / "urdf" / "drone.urdf.xacro"
    mast = (
        '<xacro:include filename="$(find parts)/mast.xacro"/>'
        '<joint name="m" type="fixed"><parent link="base_link"/><child link="mast"/></joint>'
    )
    path.write_text(path.read_text().replace("</robot>", f"{mast}</robot>"))
    (top / "yard.sdf").write_text(
        '<sdf version="1.9"><model name="cube"><static>true</static><link name="l">'
        '<collision name="c"><geometry><mesh><uri>parts/cube.obj</uri></mesh></geometry>'
        "</collision></link></model></sdf>"
    )
    (top / "yard.yaml").write_text("directives:\n  - add_model: {name: cube, file: yard.sdf}\n")
    (top / "soft.yaml").write_text("gains: {kd_velocity_z: 0.1}\n")
    return top


def read(scenario):
    """Return what a flight is built from, as far as it can be compared."""
    vehicle = configured_vehicle(scenario.vehicle)
    world = read_configured_world(scenario)
    gains = flight_gains(vehicle, scenario.vehicle.gains)
    return dataclasses.replace(vehicle, source=Path()), world.names, gains


@pytest.mark.slow
def test_what_is_shipped_gives_the_same_vehicle_and_world_elsewhere(
    workspace, monkeypatch, tmp_path_factory
):
    monkeypatch.chdir(workspace)
    named = VehicleConfig(model="drone/urdf/drone.urdf.xacro", gains="soft.yaml")
    scenario = with_absolute_paths(Scenario(vehicle=named, world="yard.yaml"))
    expected = read(scenario)
    files = shipment(scenario)
    # Other tests may have left packages in neighbours of the folder; they are looked at, too.
    inside = [path for path in map(Path, files) if path.is_relative_to(workspace)]
    names = {path.relative_to(workspace).as_posix() for path in inside}
    assert {"parts/mast.xacro", "parts/package.xml", "drone/urdf/gains.yaml"} <= names
    assert {"yard.sdf", "yard.yaml", "soft.yaml", "parts/cube.obj", "parts/cube.mtl"} <= names
    assert "parts/unused.txt" not in names
    shutil.rmtree(workspace)
    monkeypatch.chdir("/")
    kept = tmp_path_factory.mktemp("worker")
    moved = moved_below(unpack_shipment(pickle.dumps(files), kept), scenario)
    assert read(moved) == expected
    assert unpack_shipment(pickle.dumps(files), kept) == unpack_shipment(pickle.dumps(files), kept)


def test_what_is_shipped_with_the_workbench_is_not_sent():
    assert shipment(Scenario(world="empty")) is None


def test_files_that_are_too_large_are_a_sentence(tmp_path, monkeypatch):
    path = tmp_path / "soft.yaml"
    path.write_text("gains: {kp_velocity_z: 2.0}\n")
    monkeypatch.setattr(shipment_module, "MAX_SHIPMENT_BYTES", 10)
    scenario = Scenario(vehicle=VehicleConfig(gains=str(path)))
    with pytest.raises(WorkbenchError, match="MB of files, and at most 0 MB are sent"):
        shipment(scenario)


def test_threads_of_a_worker_may_unpack_at_once(tmp_path):
    files = {f"/x/{number}.yaml": b"x" * 100 for number in range(50)}

    def unpack(number):
        own = {"/own": str(number % 8).encode()}
        return unpack_shipment(pickle.dumps(files | own), tmp_path)

    with ThreadPoolExecutor(16) as pool:
        folders = set(pool.map(unpack, range(64)))
    assert len(folders) == 8
    assert set(tmp_path.iterdir()) == folders


def test_a_file_that_is_not_there_is_a_sentence():
    with pytest.raises(WorkbenchError, match="gone.yaml: no such file"):
        with_absolute_paths(Scenario(vehicle=VehicleConfig(gains="gone.yaml")))


def test_files_of_a_controller_and_an_estimator_are_sent(tmp_path):
    law, own = tmp_path / "law.py", tmp_path / "lag.py"
    law.write_text((controllers_dir() / "pd.py").read_text())
    own.write_text((Path(__file__).parents[2] / "estimation/lag.py").read_text())
    scenario = with_absolute_paths(Scenario(controller=str(law), estimator=str(own)))
    found = shipment(scenario)
    assert {str(law), str(own)} <= found.keys()
    (tmp_path / "kept").mkdir()
    root = unpack_shipment(pickle.dumps(found), tmp_path / "kept")
    moved = moved_below(root, scenario)
    assert Path(moved.controller).read_text() == law.read_text()
    assert Path(moved.estimator).read_text() == own.read_text()
