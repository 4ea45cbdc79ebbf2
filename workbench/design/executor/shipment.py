"""The files that flights read, sent along to workers that share no disk with this machine.

On a worker they lie below a folder of their own as they lay here, with the folders above them, so
that whatever is looked up beside or above a description is found there too.
"""

import copy
import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pydrake.common.yaml import yaml_dump_typed

from workbench.common.cache import cache_folder
from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_file, find_model, find_world, list_models, list_worlds
from workbench.plant.limited import LimitedError, run_limited
from workbench.scenario.scenario import Scenario

MOST_BYTES = 200_000_000
"""Of all files of a scenario."""
MOST_KEPT = 20
"""Shipments on a worker's disk; those longest unused go first."""
LONG_UNUSED = 86400.0
"""None goes that was used within this time [s]: somebody may be reading it."""
_CHILD = "workbench.design.executor.reading_child"
_SECONDS, _MEGABYTES = 120.0, 16_000


@dataclass(frozen=True)
class Shipment:
    """Files by their absolute paths here.

    Attributes:
        files: path and content of each.
    """

    files: tuple[tuple[str, bytes], ...]

    def __repr__(self) -> str:  # it stands in Dask's log lines
        return f"<Shipment of {len(self.files)} files>"

    @property
    def digest(self) -> str:
        """Of paths and contents."""
        digest = hashlib.sha256()
        for path, content in self.files:
            digest.update(f"{path}\0{len(content)}\0".encode() + content)
        return digest.hexdigest()[:32]

    def unpacked(self) -> Path:
        """Return the folder below which the files lie on this machine, written if they do not."""
        kept = cache_folder("shipped")
        folder = kept / self.digest
        if not folder.is_dir():
            partial = Path(tempfile.mkdtemp(dir=kept, prefix=".partial-"))
            for path, content in self.files:
                file = _below(partial, path)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content)
            try:
                partial.rename(folder)
            except OSError:  # another process of this machine was quicker
                shutil.rmtree(partial, ignore_errors=True)
            _forget_old(kept, time.time())
        with suppress(OSError):  # it is in use now, whenever it came
            os.utime(folder)
        return folder


def shipment(scenario: Scenario) -> Shipment | None:
    """Return the files that a scenario is read from, None where all of them are shipped ones.

    Packages that are found through environment variables are not looked for, as workers have
    others.

    Args:
        scenario: with absolute paths.

    Raises:
        WorkbenchError: if the scenario cannot be read so, or its files are too large to be sent.
    """
    if not any(True for _ in _own_paths(scenario)):
        return None
    try:
        names = run_limited(
            _CHILD,
            {"scenario": yaml_dump_typed(scenario)},
            seconds=_SECONDS,
            megabytes=_MEGABYTES,
        )
    except LimitedError as error:
        raise WorkbenchError(
            f"{scenario.vehicle.model}: what it is read from cannot be found out: {error}"
        ) from error
    size = sum(Path(name).stat().st_size for name in names)
    if size > MOST_BYTES:
        raise WorkbenchError(
            f"{scenario.vehicle.model}: is read from {size // 1_000_000} MB of files, and at most "
            f"{MOST_BYTES // 1_000_000} MB are sent to workers: fly it with smaller meshes"
        )
    return Shipment(tuple((name, Path(name).read_bytes()) for name in names))


def with_absolute_paths(scenario: Scenario) -> Scenario:
    """Return a scenario that names its files by absolute paths; shipped names stay.

    Raises:
        WorkbenchError: if one of them is not there.
    """
    found = copy.deepcopy(scenario)
    vehicle = found.vehicle
    if vehicle.model not in list_models():
        vehicle.model = str(find_model(vehicle.model))
    vehicle.rotors = str(find_file(vehicle.rotors)) if vehicle.rotors else ""
    vehicle.gains = str(find_file(vehicle.gains)) if vehicle.gains else ""
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = str(Path(folder).expanduser().resolve())
    if found.world not in list_worlds():
        found.world = str(find_world(found.world))
    return found


def moved_below(root: Path, scenario: Scenario) -> Scenario:
    """Return a scenario with absolute paths whose files lie below a folder."""

    def moved(path: str) -> str:
        return str(_below(root, path)) if path.startswith("/") else path

    found = copy.deepcopy(scenario)
    vehicle = found.vehicle
    vehicle.model, vehicle.rotors = moved(vehicle.model), moved(vehicle.rotors)
    vehicle.gains, found.world = moved(vehicle.gains), moved(found.world)
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = moved(folder)
        # one of which no file is read is there all the same
        Path(vehicle.packages[name]).mkdir(parents=True, exist_ok=True)
    return found


def _below(root: Path, path: str) -> Path:
    """Return where an absolute path comes to lie below a folder."""
    return root / path.lstrip("/")


def _own_paths(scenario: Scenario) -> Iterator[str]:
    """Yield what a scenario names that is not shipped with the workbench."""
    vehicle = scenario.vehicle
    yield from (name for name in (vehicle.rotors, vehicle.gains) if name)
    yield from vehicle.packages.values()
    if vehicle.model not in list_models():
        yield vehicle.model
    if scenario.world not in list_worlds():
        yield scenario.world


def _forget_old(kept: Path, now: float) -> None:
    """Remove the shipments that nobody has used for long, where there are many.

    Other processes write and remove here, too: what has gone meanwhile is gone, and what somebody
    is writing still is young.
    """
    used = {}
    for folder in kept.iterdir():
        with suppress(OSError):
            used[folder] = folder.stat().st_mtime
    for folder in sorted(used, key=lambda each: used[each])[:-MOST_KEPT]:
        if now - used[folder] > LONG_UNUSED:
            shutil.rmtree(folder, ignore_errors=True)
