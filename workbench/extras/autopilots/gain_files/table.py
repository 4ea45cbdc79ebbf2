"""The parameters of a firmware by version: names, meanings, defaults and ranges.

Each firmware has a folder below `tables/`:

- `versions.csv`: the versions, oldest first, and the tag and commit of the source that each was
  read from; `checked` is "no" where that source could not be had, and `note` names what the row
  rests on.
- `parameters.csv`: a row for each parameter and range of versions, in the firmware's own units.
  `since` and `until` include their versions; empty means the oldest or the newest. `law` is the
  parameter of the control law, empty if the law does not have it; `scale` is the law's value over
  the firmware's, or `peak` and `base` for the two D gains of Betaflight up to 4.5. A row without a
  name has the value with which the law flies like a version that lacks the parameter. `type` is
  empty for reals, `int`, or the words of an enumeration with | between them. `off` lists values
  without an effect on a flight here; `*` is all of them, `default` the default. `zero` says what is
  lost if the law has 0 there.
- `meanings.csv`, if any: parameters of the law with another effect since a version.
- `others.csv`, if any: names of all other parameters.
- `foreign.csv`, if any: beginnings of names that only other firmwares and vehicles have.
"""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

TABLES_FOLDER = Path(__file__).parent / "tables"
LATEST_VERSION = (10**6,)
"""Version of anything not known to be older."""
PEAK_GAIN, BASE_GAIN = "peak", "base"
ALL_VALUES, DEFAULT_VALUE = "*", "default"
WHOLE_NUMBER_TYPE = "int"
_MIN_SHARED_PREFIXES = 4

_VERSION_NUMBERS_PATTERN = re.compile(r"[^\d]{0,12}?(\d{1,4}(?:\.\d{1,4})*)")


@dataclass(frozen=True)
class Release:
    """A version of a firmware.

    Attributes:
        version: as "4.5".
        source: tag of its source, or what its rows rest on.
        commit: of that source, "" if there is none.
        checked: whether its rows were read from this source.
        note: what the rows rest on otherwise.
    """

    version: str
    source: str
    commit: str
    checked: bool
    note: str

    @property
    def numbers(self) -> tuple[int, ...]:
        """The numbers of the version."""
        return numbers_of(self.version)


@dataclass(frozen=True)
class Setting:
    """A parameter of a firmware in a range of versions; see the columns above.

    Attributes:
        name: in the firmware, "" if these versions lack it.
        since: first version, () for the oldest.
        until: last version.
        law: name in the law, "" if the law does not have it.
        scale: value of the law over that of the firmware.
        pair: `PEAK_GAIN` or `BASE_GAIN` for D gains that only have a meaning together, else "".
        default: in the firmware's unit, None if it depends on the vehicle.
        least: smallest value that the firmware takes or recommends.
        most: largest one.
        words: of an enumeration.
        whole: whether the firmware keeps whole numbers.
        off: values without an effect on a flight here, as texts.
        zero: what is lost if the law has 0, a clause; "" if nothing is.
        scope: kind of profile that has the parameter, "" for none.
    """

    name: str
    since: tuple[int, ...]
    until: tuple[int, ...]
    law: str
    scale: float
    pair: str
    default: float | None
    least: float
    most: float
    words: tuple[str, ...]
    whole: bool
    off: tuple[str, ...]
    zero: str
    scope: str = ""

    def covers(self, version: tuple[int, ...]) -> bool:
        """Return whether a version has this row."""
        return self.since <= version <= self.until

    def number(self, text: str) -> float | None:
        """Return the number of a word of the enumeration, None if it is not one of them."""
        known = {word.casefold(): float(at) for at, word in enumerate(self.words)}
        return known.get(text.strip().casefold())

    def text(self, value: float) -> str:
        """Return a value of the firmware as a person would write it."""
        if self.words and 0 <= value < len(self.words):
            return self.words[round(value)]
        return f"{value:.6g}"

    def taken(self, value: float) -> str:
        """Return what a firmware takes that refuses this value; "" if it takes it."""
        if self.words:
            return "" if 0 <= value < len(self.words) else ", ".join(self.words)
        return "" if self.least <= value <= self.most else f"{self.least:g} .. {self.most:g}"

    def is_off(self, value: float | None) -> bool:
        """Return whether a value, in the firmware's unit, has no effect on a flight here."""
        if ALL_VALUES in self.off:
            return True
        if value is None:
            return False
        if DEFAULT_VALUE in self.off:
            return self.default is None or value == self.default
        return any(value == _number_or_word_index(each, self.words) for each in self.off)


@dataclass(frozen=True)
class ParameterMeaning:
    """A parameter of the law that has another effect since a version; `note` says which."""

    law: str
    since: tuple[int, ...]
    note: str


@dataclass(frozen=True)
class FirmwareTable:
    """All versions of a firmware, oldest first, and its parameters.

    Attributes:
        releases: the versions.
        settings: parameters of flight control.
        others: names of all other parameters.
        meanings: parameters of the law that have another effect since a version.
        foreign: firmwares and vehicles by the beginnings of names that only they have.
    """

    releases: tuple[Release, ...]
    settings: tuple[Setting, ...]
    others: tuple[Setting, ...] = ()
    meanings: tuple[ParameterMeaning, ...] = ()
    foreign: Mapping[str, str] = field(default_factory=dict)

    def release(self, version: str) -> tuple[Release, str]:
        """Return the row for a version, and a remark if the table does not have that version.

        Args:
            version: as a file states it, "4.5.1" or "v1.16.0-rc1"; "" for the newest.
        """
        asked = numbers_of(version)
        if asked == LATEST_VERSION:
            return self.releases[-1], ""
        older = [each for each in self.releases if each.numbers <= asked]
        found = older[-1] if older else self.releases[0]
        if not older:
            return found, f"version {version} is older than those known: read as {found.version}"
        if asked[: len(found.numbers)] == found.numbers:
            return found, ""
        where = "newer than those known" if found is self.releases[-1] else "not one of those known"
        return found, f"version {version} is {where}: read as {found.version}"

    def place(self, version: str) -> int:
        """Return the place of a version among the releases."""
        return self.releases.index(self.release(version)[0])

    @cached_property
    def laws(self) -> frozenset[str]:
        """Parameters of laws that some version has."""
        return frozenset(each.law for each in self.settings if each.law and each.name)

    def names(self, release: Release) -> Mapping[str, Setting]:
        """Return the parameters that a version has, by their names in it."""
        return self._by_version[release.version][0]

    def by_law(self, release: Release) -> Mapping[str, Setting]:
        """Return a row of a version for each parameter of the law, even if the version lacks it."""
        return self._by_version[release.version][1]

    @cached_property
    def _by_version(self) -> Mapping[str, tuple[Mapping[str, Setting], Mapping[str, Setting]]]:
        found = {}
        for release in self.releases:
            rows = [each for each in self.settings if each.covers(release.numbers)]
            names = {each.name: each for each in rows if each.name}
            found[release.version] = names, {each.law: each for each in rows if each.law}
        return found

    def is_near(self, name: str) -> bool:
        """Return whether a name begins as several parameters of the law do, as ATC_."""
        return name.partition("_")[0] in self._groups

    @cached_property
    def _groups(self) -> frozenset[str]:
        """First words of names that several parameters of the law share."""
        names = {each.name for each in self.settings if each.law and each.name}
        starts = [name.partition("_")[0] for name in names]
        return frozenset(each for each in starts if starts.count(each) >= _MIN_SHARED_PREFIXES)

    def owner(self, name: str) -> str:
        """Return the firmware or vehicle that alone has a parameter; "" for this one, or any."""
        return next((of for start, of in self.foreign.items() if name.startswith(start)), "")

    def knows(self, name: str, release: Release | None = None) -> bool:
        """Return whether a version, or any, has a parameter."""
        return any(
            each.name == name and (release is None or each.covers(release.numbers))
            for each in (*self.settings, *self.others)
        )


def numbers_of(version: str) -> tuple[int, ...]:
    """Return the numbers of a version such as 4.6.0; those of the latest if it has none."""
    found = _VERSION_NUMBERS_PATTERN.match(version.strip())
    return tuple(int(each) for each in found[1].split(".")) if found else LATEST_VERSION


@cache
def load_table(firmware: str) -> FirmwareTable:
    """Return the table of a firmware."""
    folder = TABLES_FOLDER / firmware
    releases = tuple(
        Release(row["version"], row["source"], row["commit"], row["checked"] == "yes", row["note"])
        for row in _table_rows(folder / "versions.csv")
    )
    return FirmwareTable(
        releases,
        tuple(_setting(row) for row in _table_rows(folder / "parameters.csv")),
        tuple(_setting(row) for row in _table_rows(folder / "others.csv")),
        tuple(
            ParameterMeaning(row["law"], numbers_of(row["since"]), row["note"])
            for row in _table_rows(folder / "meanings.csv")
        ),
        {row["prefix"]: row["of"] for row in _table_rows(folder / "foreign.csv")},
    )


def _table_rows(path: Path) -> Iterator[dict[str, str]]:
    """Yield the rows of a file; none if a firmware does not have it."""
    if path.is_file():
        with path.open(encoding="utf-8", newline="") as file:
            yield from csv.DictReader(file)


def _setting(row: Mapping[str, str]) -> Setting:
    """Return the row of a file; columns that it lacks are empty."""
    kind, scale = row.get("type", ""), row.get("scale", "")
    words = tuple(kind.split("|")) if "|" in kind else ()
    pair = scale if scale in (PEAK_GAIN, BASE_GAIN) else ""
    return Setting(
        row["name"],
        numbers_of(row["since"]) if row["since"] else (),
        numbers_of(row["until"]) if row["until"] else LATEST_VERSION,
        row.get("law", ""),
        float(scale) if scale and not pair else 1.0,
        pair,
        _number_or_word_index(row.get("default", ""), words),
        float(row.get("minimum") or "-inf"),
        float(row.get("maximum") or "inf"),
        words,
        kind == WHOLE_NUMBER_TYPE or bool(words),
        tuple(filter(None, row.get("off", "").split("|"))),
        row.get("zero", ""),
        row.get("scope", ""),
    )


def _number_or_word_index(text: str, words: tuple[str, ...]) -> float | None:
    """Return a number, or the place of a word; None for neither."""
    if text in words:
        return float(words.index(text))
    try:
        return float(text)
    except ValueError:
        return None


def value_of_pair(values: Mapping[str, float], setting: Setting) -> float | None:
    """Return d, or d_min, of before 4.6 from d and d_max of the law; None if it has neither."""
    axis = setting.law.rpartition("_")[2]
    base, peak = values.get(f"d_{axis}"), values.get(f"d_max_{axis}")
    if base is None or peak is None:
        return None
    rises = round(peak) > round(base) > 0  # as the file keeps them
    if setting.pair == PEAK_GAIN:
        return peak if rises else base
    assert setting.pair == BASE_GAIN
    return base if rises else 0.0
