"""Flights on a real scheduler with two worker processes; the oracle is this process."""

import os
import socket
import subprocess
import sys
import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from far_tasks import Losing, Reading, Square

from tests.clusters import local_cluster
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.design.executor import cluster as cluster_module
from workbench.design.executor import shipment
from workbench.design.executor.cluster import (
    SCHEDULER_TIMEOUT_S,
    DaskCluster,
    check_scheduler,
    check_versions,
    process_versions,
)
from workbench.design.executor.executor import InThisProcess, LocalProcesses
from workbench.design.regress.running import regress
from workbench.design.sweep import compiled_flights, kept_flights
from workbench.design.sweep.compiled_flights import fly_fastest
from workbench.design.sweep.full_flights import fly_full
from workbench.design.sweep.sweep import sweep
from workbench.scenario.scenario import Scenario, VehicleConfig


def fly(executor):
    """Return the table of a small study with chance in it."""
    return sweep(
        ["vary.mass=0.9..1.1", "seed=0..1000000"],
        method="random",
        samples=3,
        seed=3,
        axis="x",
        duration=0.2,
        settings={"turbulence": 2.0},
        fly=partial(fly_full, executor=executor),
    )


@pytest.fixture(scope="module")
def here():
    return fly(InThisProcess())


@pytest.mark.slow
def test_a_table_is_the_same_to_the_bit_though_a_worker_is_killed(here, cluster, tmp_path):
    marker = tmp_path / "killed"
    there = fly(Losing(cluster, marker))
    assert marker.exists()
    assert there.rows.tobytes() == here.rows.tobytes()
    assert there.present_values.tobytes() == here.present_values.tobytes()


@pytest.mark.slow
def test_a_table_is_the_same_to_the_bit_though_a_process_is_killed(here, tmp_path):
    marker = tmp_path / "killed"
    there = fly(Losing(LocalProcesses(2), marker))
    assert marker.exists()
    assert there.rows.tobytes() == here.rows.tobytes()


@pytest.mark.slow
def test_compiled_flights_in_shares_are_the_same_to_the_bit_and_a_stop_keeps_whole_shares(
    cluster, tmp_path, monkeypatch
):
    monkeypatch.setattr(compiled_flights, "CANDIDATES_PER_SHARE", 4)
    file, words = tmp_path / "x.csv.unfinished", {"axis": "x", "duration": 1.0}
    monkeypatch.setattr(kept_flights, "FIRST_WRITE_DELAY_S", 0.0)
    swept, shares = ["kp_velocity_x=3..6:11"], partial(fly_fastest, cluster=cluster)
    whole = sweep(swept, **words, fly=fly_fastest)
    told = []
    part = sweep(
        swept, **words, fly=shares, kept=file, progress=told.append, stop=lambda: bool(told)
    )
    assert len(part) in {3, 7, 11}  # the present gains are one more; all may be done at once
    rest = sweep(swept, **words, fly=shares, kept=file)
    assert rest.rows.tobytes() == whole.rows.tobytes()
    local = sweep(swept, **words, fly=fly_fastest, kept=file)  # the file is of the same flights
    assert local.rows.tobytes() == whole.rows.tobytes()


@pytest.mark.slow
def test_results_stream_back_with_their_places(cluster):
    assert cluster.workers == 2
    found = dict(cluster.run([Square(number) for number in range(10)]))
    assert found == {number: number**2 for number in range(10)}
    assert list(cluster.run([])) == []


@pytest.mark.slow
def test_a_stop_keeps_what_was_finished_and_frees_the_cluster(cluster, workers):
    found = []
    for each in cluster.run([Square(n, 0.02) for n in range(500)], stop=lambda: len(found) >= 2):
        found.append(each)
    assert 2 <= len(found) < 500
    assert all(result == index**2 for index, result in found)
    assert_idle(workers)


@pytest.mark.slow
def test_who_leaves_the_loop_frees_the_cluster(cluster, workers):
    running = cluster.run([Square(number, 0.02) for number in range(500)])
    next(running)
    running.close()
    assert_idle(workers)


def assert_idle(workers) -> None:
    until = time.monotonic() + 60.0
    while workers.scheduler.tasks and time.monotonic() < until:
        time.sleep(0.02)
    assert not workers.scheduler.tasks


@pytest.mark.slow
def test_what_a_task_refuses_arrives_as_it_was_said(cluster):
    with pytest.raises(WorkbenchError, match="^13 has no square: take another number$"):
        list(cluster.run([Square(13)]))
    assert list(cluster.run([Square(2)])) == [(0, 4)]


@pytest.mark.slow
def test_a_task_that_ends_its_workers_is_a_sentence(cluster, workers, tmp_path, monkeypatch):
    monkeypatch.setattr(workers.scheduler, "allowed_failures", 0)
    with pytest.raises(WorkbenchError, match="1 workers were lost one after the other while they"):
        list(Losing(cluster, tmp_path / "killed").run([Square(1)]))


@pytest.mark.slow
def test_a_scheduler_that_is_lost_is_a_sentence(tmp_path):
    from distributed import Client  # slow to load, which quick runs need not

    file = tmp_path / "scheduler.json"
    options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file"]
    process = [sys.executable, "-m", "dask"]
    same = {
        "stderr": subprocess.DEVNULL,
        "cwd": tmp_path,
        "env": os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    }
    scheduler = subprocess.Popen([*process, "scheduler", *options, str(file)], **same)
    worker = subprocess.Popen(
        [*process, "worker", "--no-nanny", "--no-dashboard", "--scheduler-file", str(file)], **same
    )
    try:
        with Client(scheduler_file=str(file), set_as_default=False, timeout=60) as client:
            client.wait_for_workers(1, timeout=60)
            address = client.scheduler.address
        with DaskCluster(address) as cluster:
            running = cluster.run([Square(number, 0.05) for number in range(500)])
            next(running)
            scheduler.kill()
            with pytest.raises(WorkbenchError, match=f"the scheduler at {address} was lost"):
                list(running)
    finally:
        for each in (scheduler, worker):
            each.kill()
            each.wait()


@pytest.mark.slow
def test_files_are_sent_along(cluster, tmp_path, monkeypatch):
    path = tmp_path / "soft.yaml"
    path.write_text("gains: {kp_velocity_z: 2.0}\n")
    monkeypatch.chdir(tmp_path)
    scenario = Scenario(vehicle=VehicleConfig(gains="soft.yaml"))
    ((_, (read, text)),) = cluster.run([Reading(scenario)])
    assert text == path.read_text()
    assert read != str(path) and read.endswith(str(path))
    path.write_text("gains: {kp_velocity_z: 2.0}  # mute\n")
    with pytest.raises(WorkbenchError) as caught:
        list(cluster.run([Reading(scenario)]))
    assert str(caught.value) == f"{path}:1: it is mute: write something else"


@pytest.mark.slow
def test_a_regression_is_the_same_there(cluster, tmp_path):
    path = tmp_path / "s.workbench.yaml"
    (tmp_path / "soft.yaml").write_text("gains: {kp_velocity_z: 2.0}\n")
    path.write_text(
        "vehicle: {gains: soft.yaml}\n"
        "cases:\n  - {name: a, axis: z, amplitude: 1, duration: 0.3, limits: {peak: {max: 0.1}}}\n"
        "margins: {roll: {phase_margin: {min: 0.1}}}\n"
    )
    there, here = regress([path], executor=cluster), regress([path])
    for one, other in zip(there, here, strict=True):
        assert one.path == other.path == path
        assert one.failures == other.failures
        assert one.checks == other.checks
        for curve, twin in zip(one.curves, other.curves, strict=True):
            np.testing.assert_array_equal(curve.flown.values, twin.flown.values)
    assert [result.passed for result in here] == [False, True]


@pytest.mark.slow
def test_the_commands_fly_there_and_say_so_once(workers, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    there = ["--scheduler", workers.scheduler_address]
    words = ["sweep", "kp_velocity_z=4..5:2", "--duration", "0.3", "--no-plots"]
    assert main([*words, "--full", *there]) == 0
    said = capsys.readouterr()
    assert said.err.count(f"flying on 2 workers of {workers.scheduler_address}") == 1
    assert "2 candidates" in said.out
    assert main(["regress", "margins", *there]) == 0
    assert "flying on 2 workers" in capsys.readouterr().err


@pytest.mark.parametrize(
    "address", ["here", "localhost:8786", "tcp://localhost", "tcp://:8786", "tcp://h:99999", "8786"]
)
def test_what_is_no_address_is_refused(address):
    with pytest.raises(WorkbenchError, match="write tcp://HOST:PORT, as tcp://localhost:8786"):
        check_scheduler(address)


def test_a_closed_port_is_a_sentence(capsys):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    for words in (["sweep", "kp_roll=100..200:2", "--full"], ["regress"]):
        assert main([*words, "--scheduler", address]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"workbench: no scheduler can be reached at {address}")
        assert "Connection refused" in said


def test_what_never_answers_is_given_up_within_five_seconds():
    assert 2.0 * SCHEDULER_TIMEOUT_S <= 4.0  # to connect and to be answered, and a second to start
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(
            WorkbenchError, match="the program at that address does not answer like one"
        ):
            check_scheduler(address, within=0.2)


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(cluster_module.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(WorkbenchError, match="`pip install distributed`"):
        check_scheduler("tcp://localhost:8786")


@pytest.mark.slow
def test_workers_without_the_package_are_named(tmp_path):
    from distributed import Client

    broken = tmp_path / "workbench" / "__init__.py"
    broken.parent.mkdir()
    broken.write_text("raise ImportError('not here')\n")
    with local_cluster(0) as empty:
        address = empty.scheduler_address
        with pytest.raises(WorkbenchError, match=f"no workers: .*dask worker {address}"):
            DaskCluster(address)
        worker = subprocess.Popen(
            [sys.executable, "-m", "dask", "worker", address, "--no-nanny", "--no-dashboard"],
            env={"PYTHONPATH": str(tmp_path), "HOME": str(tmp_path)},
            cwd=tmp_path,
            stderr=subprocess.DEVNULL,
        )
        try:
            with Client(address, set_as_default=False) as client:
                client.wait_for_workers(1, timeout=60)
            with pytest.raises(WorkbenchError, match="the worker tcp://.* lacks drake-drone-work"):
                DaskCluster(address)
        finally:
            worker.kill()
            worker.wait()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("workbench", "has another version of the workbench's source"),
        ("drake", "has drake 1.0, but here it is"),
        ("processor", "has a processor of kind 1.0, but here"),
    ],
)
def test_a_worker_with_another_version_is_named(name, said):
    there = process_versions() | {name: "1.0"}
    with pytest.raises(WorkbenchError, match=f"the worker tcp://w:1 {said}"):
        check_versions("tcp://w:1", there, process_versions())
    check_versions("tcp://w:1", process_versions(), process_versions())


def test_a_sentence_of_a_worker_has_the_paths_of_the_caller(tmp_path, monkeypatch):
    """The worker unpacked the files below a folder of its own, which says nothing to the user."""

    class Refused:
        scenario = Scenario()

        def with_scenario(self, scenario):
            return self

        def run(self):
            raise WorkbenchError(f"{tmp_path}/data/models/drone.urdf:3: has no links")

    worker = SimpleNamespace(address="tcp://w:1", local_directory=str(tmp_path))
    monkeypatch.setattr("distributed.get_worker", lambda: worker)
    monkeypatch.setattr(shipment, "unpack_shipment", lambda files, folder: tmp_path)
    monkeypatch.setattr(cluster_module, "pickle", SimpleNamespace(loads=lambda task: Refused()))
    with pytest.raises(WorkbenchError) as caught:
        cluster_module.run_there(b"", b"", process_versions())
    assert str(caught.value) == "/data/models/drone.urdf:3: has no links"
