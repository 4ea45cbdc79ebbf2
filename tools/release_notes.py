"""Check that a release is ready to be built, and print what CHANGELOG.md says of it.

The version of pyproject.toml is the newest heading below Unreleased, with its date; nothing is left
under Unreleased; CITATION.cff has the same version and date.
"""

import re
import sys
import tomllib
from pathlib import Path

from apt import leave

ROOT = Path(__file__).resolve().parent.parent


def main():
    """Print the notes of the release, or leave with a sentence."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT
    version = tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"]
    _, *sections = re.split(r"^## ", (root / "CHANGELOG.md").read_text(), flags=re.MULTILINE)
    if len(sections) < 2:
        leave("CHANGELOG.md: has no section of a release below Unreleased")
    unreleased, newest = (section.partition("\n") for section in sections[:2])
    if unreleased[0] != "[Unreleased]" or unreleased[2].strip():
        leave(f"CHANGELOG.md: Unreleased is not empty: move its lines below `## {version} - DATE`")
    dated = re.fullmatch(r"(\S+) - (\d{4}-\d\d-\d\d)", newest[0])
    if dated is None or dated[1] != version:
        leave(
            f"CHANGELOG.md: the newest section is `{newest[0]}`, and pyproject.toml has version "
            f"{version}: name it `{version} - DATE`"
        )
    citation = (root / "CITATION.cff").read_text()
    for line in (f"version: {version}", f"date-released: {dated[2]}"):
        if not re.search(rf"^{re.escape(line)}$", citation, re.MULTILINE):
            leave(f"CITATION.cff: has no line `{line}`, as CHANGELOG.md says: change it")
    print(newest[2].strip())


if __name__ == "__main__":
    main()
