"""The report on imported or exported gains: differences, margins, and what is not flown."""

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.gain_tables import percent_change
from workbench.commands.printing import print_result, print_table
from workbench.commands.translated_gains import TranslatedGains

if TYPE_CHECKING:
    from workbench.design.judge.margins import LoopMargins
    from workbench.gains.formats import ImportedGains
    from workbench.gains.gain_change import GainChange
    from workbench.gains.parameter_line import ParameterFileRemark, ParameterLine


def print_exchange(
    args: argparse.Namespace,
    about: Mapping[str, Any],
    changes: "Sequence[GainChange]",
    margins: "Sequence[dict[str, LoopMargins]]",
    remarks: "Sequence[ParameterFileRemark]",
    found: "ImportedGains | None",
    translated: TranslatedGains | None,
    exports: bool = False,
) -> None:
    """Print differences, margins and remarks, and the translation before or after them, if any."""
    from workbench.control.controller_file import load_controller
    from workbench.gains.formats import find_firmware

    firmware = find_firmware(about["firmware"])
    table = load_controller(args.controller).table
    wrong = found.unsafe if found else {}
    before, after = margins or ({}, {})
    result = {
        **about,
        "gains": [
            row._asdict()
            | {
                "file_name": firmware.file_name(row.name),
                "meaning": table.find(row.name).help,
                "origin": _origin(row.name, found),
            }
            for row in changes
        ],
        "unsafe": wrong,
        **_unflown(found),
        "margins": [
            {"loop": loop, "before": margins, "after": after[loop]}
            for loop, margins in before.items()
        ],
        "remarks": [str(each) for each in remarks],
        "remark_details": [
            {"text": each.text, "place": _place(about["file"], each), "count": each.count}
            for each in remarks
        ],
        "translation": translated.result() if translated else None,
    }

    def show() -> None:
        if translated and exports:
            translated.show()
            print()
        release = f"{about['firmware']} {about['version']}".rstrip()
        print(f"{about['file']}: {release}, law {about['controller']}, vehicle {about['vehicle']}")
        differing = [row for row in changes if row.a != row.b]
        if differing:
            sides = ("file", "new") if exports else ("now", "file")
            lines = [
                (
                    firmware.file_name(row.name),
                    f"{row.a:.5g}",
                    f"{row.b:.5g}",
                    row.unit,
                    percent_change(row.percent),
                    table.find(row.name).help
                    + (" (default)" if _origin(row.name, found) == "default" else ""),
                )
                for row in differing
            ]
            print_table([("", *sides, "", "change", "meaning"), *lines], left=(0, 3, 5))
        print(f"{len(differing)} of {len(changes)} gains differ")
        for name, why in wrong.items():
            print(f"unsafe: {firmware.file_name(name)} {why}")
        if margins:
            print()
            print_margins(*margins)
        if found and found.lines:
            _print_unflown(found)
        for remark in remarks:
            print(f"note: {remark}")
        if translated and not exports:
            print()
            translated.show()

    saved = [args.save] if not exports and args.save and not wrong else []
    print_result(args, result, show, files=saved)


def _place(file: Path, remark: "ParameterFileRemark") -> str:
    return f"{file}:{remark.line}" if remark.line else str(file)


def _origin(name: str, found: "ImportedGains | None") -> str:
    """Return where the value of a gain comes from: the file, or its version."""
    return "default" if found and name not in found.values else "file"


def _unflown(found: "ImportedGains | None") -> dict[str, Any]:
    """Return what each line of a file is, and what the law does not have."""
    if found is None:
        return {"not_flown": (), "on_by_default": (), "account": {}, "lines": []}
    acting = [each for each in found.left if each.acts]
    return {
        "not_flown": [each.name for each in found.left],
        "acting": [{"name": each.name, "value": each.text, "line": each.line} for each in acting],
        "on_by_default": [str(each) for each in found.standing],
        "account": {
            part: {"count": len(lines), "names": sorted({each.name for each in lines} - {""})}
            for part, lines in _parts(found).items()
        },
        "lines": [
            {
                "line": each.number,
                "name": each.name,
                "value": each.text,
                "part": each.part,
                "why": each.why,
            }
            for each in found.lines
        ],
    }


def _parts(found: "ImportedGains") -> "dict[str, list[ParameterLine]]":
    """Return the lines of a file by what becomes of them."""
    from workbench.gains.parameter_line import LINE_FLOWN, LINE_NOT_FLOWN, LINE_UNKNOWN

    parts = (LINE_FLOWN, LINE_NOT_FLOWN, LINE_UNKNOWN)
    return {part: [each for each in found.lines if each.part == part] for part in parts}


def _print_unflown(found: "ImportedGains") -> None:
    """Print the parameters of flight control that the law does not have, with their values."""
    counts = {part: len(lines) for part, lines in _parts(found).items()}
    print(
        f"lines: {', '.join(f'{count} {part}' for part, count in counts.items())}; "
        "--json accounts for each"
    )
    acting = [str(each) for each in found.left if each.acts]
    others = [each.name for each in found.left if not each.acts]
    if acting:
        print(f"not simulated, and not imported: {', '.join(acting)}")
    if others:
        print(f"not imported, and without effect here: {', '.join(others)}")
    if found.standing:
        print(
            f"on by default in {found.read_as}, and not simulated: "
            f"{', '.join(map(str, found.standing))}"
        )


def print_margins(before: "dict[str, LoopMargins]", after: "dict[str, LoopMargins]") -> None:
    """Print margins of loops by name, before and after."""
    rows: list[tuple[str, ...]] = [
        ("loop", "phase margin [deg]", "", "gain margin", "", "crossover [rad/s]", ""),
        ("", "before", "after", "before", "after", "before", "after"),
    ]
    for loop in before:
        sides = before[loop], after[loop]
        phases = [_cell(each, math.degrees(each.phase_margin)) for each in sides]
        factors = [_cell(each, each.gain_margin) for each in sides]
        crossovers = [_cell(each, each.crossover) for each in sides]
        rows.append((loop, *phases, *factors, *crossovers))
    print_table(rows)


def _cell(margins: "LoopMargins", value: float) -> str:
    if not margins.stable:
        return "unstable"
    return "none" if not math.isfinite(value) else f"{value:.3g}"
