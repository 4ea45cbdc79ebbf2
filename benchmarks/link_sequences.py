"""Does any sequence of what clients do make the server fail, grow, or harm a client that is good?

The sequences of tests/link/server/sequences.py, ten times as many: logins, subscriptions, requests,
commands, acknowledgements, broken frames and bits turned, in pieces of any size, with clients that
stop reading, vanish, or are sent away, against the hub with connections that are made up.

`python benchmarks/link_sequences.py 2000` plays fewer.
"""

import importlib.util
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

TESTS = Path(__file__).resolve().parents[1] / "tests" / "link" / "server"
SEQUENCES = 20_000
SETTLED = 1000
"""After so many memory is looked at for the first time."""


@dataclass(frozen=True)
class LinkSequencesRow:
    """What came of it.

    Attributes:
        sequences: that were played.
        wrong: that did harm.
        memory_start: resident, after the first thousand, or the first tenth [MB].
        memory_end: at the end [MB].
        seconds: that it took.
    """

    sequences: int
    wrong: int
    memory_start: float
    memory_end: float
    seconds: float


def measure(count: int = SEQUENCES) -> LinkSequencesRow:
    """Play so many."""
    parts, sequences = _load("conftest"), _load("sequences")
    begun = time.perf_counter()
    wrong, start = 0, 0.0
    for seed in range(count):
        if seed == min(SETTLED, count // 10):
            start = _memory()
        said = sequences.play(parts, seed)
        if said:
            wrong += 1
            print(f"seed {seed}: {said}", file=sys.stderr)
    return LinkSequencesRow(count, wrong, start, _memory(), time.perf_counter() - begun)


def _load(name: str) -> ModuleType:
    """Return a module of the tests."""
    spec = importlib.util.spec_from_file_location(f"link_server_{name}", TESTS / f"{name}.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def _memory() -> float:
    """Return what this process holds [MB]."""
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024.0
    return 0.0


def show(row: LinkSequencesRow) -> None:
    """Print it."""
    print(
        f"{row.sequences:,} sequences, {row.wrong} did harm; memory {row.memory_start:.1f} MB "
        f"at the start, {row.memory_end:.1f} at the end; {row.seconds:.0f} s"
    )


if __name__ == "__main__":
    show(measure(int(sys.argv[1]) if len(sys.argv) > 1 else SEQUENCES))
