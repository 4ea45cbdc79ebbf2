"""Mutated copies of every kind of file that others write, through the commands that read them.

`python benchmarks/mutated_files.py --files 100000 --seed 1` takes about an hour on two cores. A
file must be understood (exit code 0) or refused with one sentence (2). All else is a fault and is
listed with its number; `--only NUMBER --keep FOLDER` repeats one and keeps its file.

Files are read in processes that the kernel holds, each many of them: what a command hands to a held
process of its own (logs, xacro, meshes) is computed in the same one. If a process dies, its file is
a fault, and another process goes on with the next file.
"""

import argparse
import contextlib
import json
import os
import shutil
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from mutated_reader import NOTES, ROOT
from mutation_originals import write_originals

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import run_limited

HERE = Path(__file__).resolve().parent
BATCH = 500
"""Files that one process reads."""
SECONDS, MEGABYTES = 1800.0, 4000
"""Limits of a process."""


@dataclass
class Tally:
    """What became of files.

    Attributes:
        understood: by kind.
        refused: by kind.
        clauses: what an unexpected exception in a held process became, and how often.
        faults: number and kind of a file, and what was wrong.
        slowest: longest processor time [s], and the file.
        memory: peak [MB].
    """

    understood: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    clauses: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    slowest: tuple[float, str] = (0.0, "")
    memory: float = 0.0

    def add(self, other: "Tally") -> None:
        """Add those of another process."""
        self.understood += other.understood
        self.refused += other.refused
        self.clauses += other.clauses
        self.faults += other.faults
        self.slowest = max(self.slowest, other.slowest)
        self.memory = max(self.memory, other.memory)


def main() -> int:
    """Mutate, read, and print what became of the files; return 1 if there is a fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--files", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--kinds", nargs="+", default=[], help="only these kinds")
    parser.add_argument("--only", type=int, help="number of a single file")
    parser.add_argument("--keep", type=Path, help="folder that keeps the last file of each process")
    arguments = parser.parse_args()
    numbers = range(arguments.first, arguments.first + arguments.files)
    if arguments.only is not None:
        numbers = range(arguments.only, arguments.only + 1)
    begun = time.monotonic()
    tally = measure(arguments.seed, numbers, arguments.jobs, arguments.kinds, arguments.keep)
    show(tally, arguments.seed, time.monotonic() - begun)
    return 1 if tally.faults else 0


def measure(
    seed: int,
    numbers: range,
    jobs: int = 1,
    kinds: Sequence[str] = (),
    keep: Path | None = None,
) -> Tally:
    """Return what became of the files with some numbers.

    Args:
        seed: of all of them.
        numbers: of the files.
        jobs: number of processes side by side.
        kinds: those to mutate; all if there are none.
        keep: folder for the last file of each process.
    """
    batches = [numbers[i : i + BATCH] for i in range(0, len(numbers), BATCH)]
    tally, lock = Tally(), threading.Lock()
    with tempfile.TemporaryDirectory() as folder, _found_by_python(HERE):
        originals = Path(folder) / "originals"
        originals.mkdir()
        write_originals(originals)

        def run(batch: range) -> None:
            found = _read_batch(seed, batch, originals, kinds, keep)
            with lock:
                tally.add(found)
                done = tally.understood.total() + tally.refused.total() + len(tally.faults)
                print(f"{done:,} files, {len(tally.faults)} faults", file=sys.stderr, flush=True)

        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(run, batches))
    return tally


@contextlib.contextmanager
def _found_by_python(folder: Path) -> Iterator[None]:
    """Let the processes that are started find the modules of a folder."""
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (str(folder), before)))
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before


def show(tally: Tally, seed: int, duration: float) -> None:
    """Print a table by kind, and the line for a report."""
    print(f"{'kind':28} {'understood':>10} {'refused':>10}")
    for kind in sorted(tally.understood | tally.refused):
        print(f"{kind:28} {tally.understood[kind]:10,} {tally.refused[kind]:10,}")
    for clause, count in tally.clauses.most_common(20):
        print(f"held process, {count} times: {clause}")
    for fault in tally.faults:
        print(f"FAULT {fault}")
    understood, refused = tally.understood.total(), tally.refused.total()
    seconds, file = tally.slowest
    print(
        f"mutated files: {understood + refused + len(tally.faults):,} of seed {seed}, "
        f"{len(tally.understood | tally.refused)} kinds: {understood:,} understood, {refused:,} "
        f"refused with a sentence, {len(tally.faults)} faults; slowest {seconds:.1f} s ({file}), "
        f"{tally.memory:.0f} MB, {duration / 60.0:.0f} min"
    )


def _read_batch(
    seed: int, batch: range, originals: Path, kinds: Sequence[str], keep: Path | None
) -> Tally:
    """Read the files of a batch in a held process, in another one after each death."""
    tally, before = Tally(), -1
    while batch:
        with tempfile.TemporaryDirectory() as folder:
            work = Path(folder)
            request = {
                "seed": seed,
                "numbers": [batch.start, batch.stop],
                "originals": str(originals),
                "kinds": list(kinds),
                "folder": folder,
            }
            try:
                run_limited(
                    "mutated_reader",
                    request,
                    seconds=SECONDS,
                    megabytes=MEGABYTES,
                    reads=[ROOT, originals],
                    writes=[folder],
                )
                died = ""
            except WorkbenchError as error:
                died = str(error)
            lines = (work / NOTES).read_text().splitlines() if (work / NOTES).exists() else []
            last, at = _collect(tally, lines, batch.start)
            if keep is not None and (work / "file").exists():
                shutil.copytree(work / "file", keep, dirs_exist_ok=True)
        if not died:
            return tally
        before, again = at, at == before
        if again:  # once, it may be that somebody killed it, or the system for its memory
            tally.faults.append(f"{last or at}: the process died: {died}")
        batch = range(at + again, batch.stop)
    return tally


def _collect(tally: Tally, lines: Sequence[str], first: int) -> tuple[str, int]:
    """Add what a process noted; return the last file, and the number of the next to be read."""
    last, following = "", first
    for line in lines:
        said = json.loads(line)
        last = f"{said['number']} {said['kind']}"
        following = said["number"]
        if "outcome" not in said:
            continue  # it was begun
        following += 1
        match said["outcome"]:
            case 0:
                tally.understood[said["kind"]] += 1
            case 2:
                tally.refused[said["kind"]] += 1
            case fault:
                tally.faults.append(f"{last}: {fault}")
        tally.clauses.update(said["clauses"])
        tally.slowest = max(tally.slowest, (said["seconds"], last))
        tally.memory = max(tally.memory, said["megabytes"])
    return last, following


if __name__ == "__main__":
    sys.exit(main())
