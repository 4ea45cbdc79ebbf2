"""Read mutated copies of descriptions, as a process of its own with bounds on its memory and time.

`python mutate.py FOLDER SEED COUNT FILE...` prints one JSON object: how many were understood, how
many refused in a sentence, and every other outcome with its seed.
"""

import json
import random
import re
import resource
import sys
import time
from pathlib import Path

NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
ELEMENT = re.compile(r"<(\w+)\b[^<>]*(?:/>|>[^<>]*</\1>)")
WORDS = (
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-308",
    "",
    "abc",
    "1 2",
    "1e5",
    "\u00fc",
    "%s",
)
MEMORY = 3_000_000_000
SLOWEST = 60.0
"""A single description may take this long, on a very slow machine [s]."""


def mutated(text: str, random: random.Random) -> str:
    """Return a text with one to four things wrong."""
    for _ in range(random.randint(1, 4)):
        text = random.choice(MUTATIONS)(text, random)
    return text


def truncate(text: str, random: random.Random) -> str:
    return text[: random.randrange(len(text) + 1)]


def spoil_number(text: str, random: random.Random) -> str:
    return _replaced(text, NUMBER, random, lambda _: random.choice(WORDS))


def swap_numbers(text: str, random: random.Random) -> str:
    numbers = NUMBER.findall(text) or ["1"]
    return _replaced(text, NUMBER, random, lambda _: random.choice(numbers))


def drop_element(text: str, random: random.Random) -> str:
    return _replaced(text, ELEMENT, random, lambda _: "")


def repeat_element(text: str, random: random.Random) -> str:
    times = random.choice((2, 3, 1000))
    return _replaced(text, ELEMENT, random, lambda match: match[0] * times)


def move_element(text: str, random: random.Random) -> str:
    elements = [match[0] for match in ELEMENT.finditer(text)] or [""]
    return _replaced(text, ELEMENT, random, lambda match: match[0] + random.choice(elements))


def deepen(text: str, random: random.Random) -> str:
    times = random.choice((5, 50, 5000))
    return _replaced(
        text, ELEMENT, random, lambda m: f"<{m[1]}>" * times + m[0] + f"</{m[1]}>" * times
    )


def rename(text: str, random: random.Random) -> str:
    names = re.findall(r'"([^"<>]*)"', text) or ["x"]
    pattern = re.compile(r'(?<=")[^"<>]*(?=")')
    return _replaced(text, pattern, random, lambda _: random.choice([*names, "", "x" * 100_000]))


def flip(text: str, random: random.Random) -> str:
    place = random.randrange(len(text) + 1)
    return text[:place] + chr(random.randrange(1, 0x3000)) + text[place + 1 :]


MUTATIONS = (
    truncate,
    spoil_number,
    spoil_number,
    spoil_number,
    swap_numbers,
    drop_element,
    repeat_element,
    move_element,
    deepen,
    rename,
    flip,
)


def _replaced(text: str, pattern: re.Pattern, random: random.Random, make) -> str:
    """Return a text with one match, chosen at random, replaced."""
    matches = list(pattern.finditer(text))
    if not matches:
        return text
    match = random.choice(matches)
    return text[: match.start()] + make(match) + text[match.end() :]


def main(folder: Path, seed: int, count: int, files: list[Path]) -> dict[str, object]:
    from workbench.common.errors import WorkbenchError
    from workbench.plant.loading import load_vehicle

    understood, refused, faults = 0, 0, []
    for number in range(seed, seed + count):
        chance = random.Random(number)
        original = chance.choice(files)
        path = folder / f"mutated_{number}{original.suffix}"
        text = mutated(original.read_text(), chance)
        path.write_text(text, encoding="utf-8", errors="replace")
        start = time.monotonic()
        try:
            load_vehicle(path, {}, {"rotors_description": str(original.parent)})
            understood += 1
        except WorkbenchError as error:
            refused += 1
            if "\n" in str(error) or len(str(error)) > 5000:
                faults.append(f"{number} {original.name}: no sentence: {str(error)[:300]}")
        except BaseException as error:  # whatever it is, it is a fault
            faults.append(f"{number} {original.name}: {type(error).__name__}: {str(error)[:300]}")
        if time.monotonic() - start > SLOWEST:
            faults.append(f"{number} {original.name}: took {time.monotonic() - start:.0f} s")
        path.unlink()
    return {"understood": understood, "refused": refused, "faults": faults}


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    folder, seed, count, *files = sys.argv[1:]
    print(json.dumps(main(Path(folder), int(seed), int(count), [Path(file) for file in files])))
