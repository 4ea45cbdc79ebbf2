"""Install the programs that some tests need and no wheel brings; without them these tests skip."""

import shutil
from pathlib import Path

from apt import install

PROGRAMS = {
    "chromium": "chromium",
    "g++": "g++",
    "gcc": "gcc",
    "node": "nodejs",
    "openssl": "openssl",
}
"""The Debian package of each program."""
HEADERS = {
    "/usr/include/fastrtps/fastrtps_dll.h": "libfastrtps-dev",
    "/usr/include/fastcdr/fastcdr_dll.h": "libfastcdr-dev",
}
"""The Debian package of each file."""


def main():
    """Install what is missing, or leave with a sentence."""
    missing = {package for name, package in PROGRAMS.items() if shutil.which(name) is None}
    missing |= {package for name, package in HEADERS.items() if not Path(name).exists()}
    if missing:
        install(missing, "Programs for some tests are missing")


if __name__ == "__main__":
    main()
