"""Betaflight's simplified tuning: gains and filters that its sliders compute."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace

from workbench.extras.autopilots.gain_files.parameter_file import (
    ParameterEntry,
    ParameterFile,
    number_in,
)
from workbench.extras.autopilots.gain_files.table import Release, Setting, load_table
from workbench.gains.formats import single
from workbench.gains.parameter_line import ParameterFileRemark

APPLY_TUNING, DISABLE_TUNING = "simplified_tuning apply", "simplified_tuning disable"
SCOPE_SEPARATOR = ", "
_CLI_AXES = ("roll", "pitch", "yaw")
_SLIDER_AXIS_COUNTS = {"OFF": 0, "RP": 2, "RPY": 3}
"""Number of axes that the sliders set."""


def _of_profiles(file: ParameterFile) -> Iterator[ParameterFileRemark]:
    """Yield remarks on profiles that do not count."""
    entries = [each for each in file.entries if each.scope.startswith("profile")]
    profiles = list(dict.fromkeys(each.scope for each in entries))
    counted = next((each for each in file.scopes if each.startswith("profile")), "")
    if len(profiles) > 1:
        others = [each for each in entries if each.scope != counted]
        yield ParameterFileRemark(
            f"has {', '.join(profiles)}: {counted} counts, --profile takes another",
            others[0].line,
            len(others),
        )
    if counted and profiles and counted not in profiles:
        yield ParameterFileRemark(
            f"sets nothing in {counted}, but does in {', '.join(profiles)}",
            entries[0].line,
            len(entries),
        )


def with_computed_values(file: ParameterFile, release: Release) -> ParameterFile:
    """Return a file in which commands that compute values have run, as in a version.

    Their values are entries behind the line of the command, with a negative `start`.
    """
    table = load_table("betaflight")
    names = table.names(release)
    entries: list[ParameterEntry] = []
    file = replace(file, entries=tuple(_scoped(each, names) for each in file.entries))
    remarks, commands = [*file.remarks, *_of_profiles(file)], list(file.commands)
    for entry in file.entries:
        if entry.name not in (APPLY_TUNING, DISABLE_TUNING):
            entries.append(entry)
            continue
        if "simplified_pids_mode" not in names:
            said = f"is no command of {release.version}"
            remarks.append(ParameterFileRemark(f"'{entry.name}' {said}", entry.line))
            commands = [
                replace(each, left=said, known=False) if each.line == entry.line else each
                for each in commands
            ]
            continue
        present = replace(file, entries=tuple(entries)).counted
        run = _disabled() if entry.name == DISABLE_TUNING else _applied(present, names)
        entries += [
            ParameterEntry(name, number_in(text), text, -1, entry.line, "", True)
            for name, text in run.items()
        ]
        if entry.name == APPLY_TUNING:
            said = f"'{APPLY_TUNING}' computes {len(run)} values from the sliders"
            remarks.append(ParameterFileRemark(said, entry.line, len(run)))
    return replace(file, entries=tuple(entries), remarks=tuple(remarks), commands=tuple(commands))


def _scoped(entry: ParameterEntry, names: Mapping[str, Setting]) -> ParameterEntry:
    """Return an entry that applies to the profile selected at its line, if that has the name."""
    setting = names.get(entry.name)
    kind = f"{setting.scope} " if setting and setting.scope else "?"
    chosen = [each for each in entry.scope.split(SCOPE_SEPARATOR) if each.startswith(kind)]
    return replace(entry, scope=chosen[0] if chosen else "")


def _disabled() -> dict[str, str]:
    return {
        "simplified_pids_mode": "OFF",
        "simplified_dterm_filter": "OFF",
        "simplified_gyro_filter": "OFF",
    }


def _applied(present: Mapping[str, ParameterEntry], names: Mapping[str, Setting]) -> dict[str, str]:
    """Return the values, as texts, that the sliders compute.

    Args:
        present: what the file has set so far; other values are the defaults.
        names: of the version.
    """

    def text(name: str) -> str:
        if name in present:
            return present[name].text
        return names[name].text(names[name].default or 0.0)

    def value(name: str) -> float:
        return number_in(text(name)) or 0.0

    mode = text("simplified_pids_mode").upper()
    found = dict(_slider_gains(value, names, _CLI_AXES[: _SLIDER_AXIS_COUNTS.get(mode, 3)]))
    if text("simplified_dterm_filter").upper() != "OFF":
        found |= _filters(value, names, "dterm", int(value("simplified_dterm_filter_multiplier")))
    if text("simplified_gyro_filter").upper() != "OFF":
        found |= _filters(value, names, "gyro", int(value("simplified_gyro_filter_multiplier")))
    return {name: str(number) for name, number in found.items()}


def _slider_gains(
    value: Callable[[str], float], names: Mapping[str, Setting], axes: Iterable[str]
) -> Iterator[tuple[str, int]]:
    """Yield the gains of some axes, as `calculateNewPidValues` does."""

    def default(name: str) -> float:
        return names[name].default or 0.0

    def product(*factors: float) -> float:
        found = factors[0]
        for factor in factors[1:]:
            found = single(found * factor)
        return found

    def cut(name: str, *factors: float) -> tuple[str, int]:
        most = names[name].most
        return name, int(min(max(product(*factors), 0.0), most))

    def slider(name: str) -> float:
        return single(value(f"simplified_{name}") / 100.0)

    before = "d_min_roll" in names
    whole, pi, d, i = map(slider, ("master_multiplier", "pi_gain", "d_gain", "i_gain"))
    feed, peak = slider("feedforward_gain"), slider("dmax_gain" if before else "d_max_gain")
    for axis in axes:
        of_pitch = axis == "pitch"
        more_d = slider("pitch_d_gain") if of_pitch else 1.0
        more_pi = slider("pitch_pi_gain") if of_pitch else 1.0
        yield cut(f"p_{axis}", default(f"p_{axis}"), whole, pi, more_pi)
        yield cut(f"i_{axis}", default(f"i_{axis}"), whole, pi, i, more_pi)
        yield cut(f"f_{axis}", default(f"f_{axis}"), whole, more_pi, feed)
        if before:
            least, most = default(f"d_min_{axis}"), default(f"d_{axis}")
            rise = single((most - least) / least) if least > 0.0 else 0.0
            ratio = single(1.0 + single(rise * peak))
            yield cut(f"d_{axis}", least, whole, d, more_d, ratio)
            yield cut(f"d_min_{axis}", least, whole, d, more_d)
        else:
            base, most = default(f"d_{axis}"), default(f"d_max_{axis}")
            ratio = 1.0
            if most > 0.0:
                ratio = single(peak + single(single(single(1.0 - peak) * base) / most))
            yield cut(f"d_{axis}", base, whole, d, more_d)
            yield cut(f"d_max_{axis}", most, whole, d, more_d, ratio)


def _filters(
    value: Callable[[str], float], names: Mapping[str, Setting], kind: str, percent: int
) -> dict[str, int]:
    """Return cut-offs of the low-passes that are on, as `calculateNewDTermFilterValues` does."""

    def scaled(name: str) -> int:
        setting = names[f"{kind}_{name}"]
        return min(int(setting.default or 0.0) * percent // 100, int(setting.most))

    found = {}
    if value(f"{kind}_lpf1_dyn_min_hz"):
        found[f"{kind}_lpf1_dyn_min_hz"] = scaled("lpf1_dyn_min_hz")
        found[f"{kind}_lpf1_dyn_max_hz"] = scaled("lpf1_dyn_max_hz")
    if value(f"{kind}_lpf1_static_hz"):
        found[f"{kind}_lpf1_static_hz"] = scaled("lpf1_dyn_min_hz")
    if value(f"{kind}_lpf2_static_hz"):
        found[f"{kind}_lpf2_static_hz"] = scaled("lpf2_static_hz")
    return found
