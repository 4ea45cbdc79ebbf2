"""System libraries needed by Qt and Drake: missing ones, and their Debian packages.

`make` uses this to install them, and the app reports them before Qt would end the process.
"""

import os
import re
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path

DEBIAN_PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11-xcb.so.1": "libx11-xcb1",
    "libX11.so.6": "libx11-6",
    "libbrotlidec.so.1": "libbrotli1",
    "libdbus-1.so.3": "libdbus-1-3",
    "libexpat.so.1": "libexpat1",
    "libfontconfig.so.1": "libfontconfig1",
    "libfreetype.so.6": "libfreetype6",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libgssapi_krb5.so.2": "libgssapi-krb5-2",
    "libgthread-2.0.so.0": "libglib2.0-0",
    "libpng16.so.16": "libpng16-16",
    "libstdc++.so.6": "libstdc++6",
    "libwayland-client.so.0": "libwayland-client0",
    "libwayland-cursor.so.0": "libwayland-cursor0",
    "libwayland-egl.so.1": "libwayland-egl1",
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-glx.so.0": "libxcb-glx0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-image.so.0": "libxcb-image0",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-randr.so.0": "libxcb-randr0",
    "libxcb-render-util.so.0": "libxcb-render-util0",
    "libxcb-render.so.0": "libxcb-render0",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxcb-shm.so.0": "libxcb-shm0",
    "libxcb-sync.so.1": "libxcb-sync1",
    "libxcb-util.so.1": "libxcb-util1",
    "libxcb-xfixes.so.0": "libxcb-xfixes0",
    "libxcb-xkb.so.1": "libxcb-xkb1",
    "libxcb.so.1": "libxcb1",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
    "libxkbcommon.so.0": "libxkbcommon0",
}
"""The Debian package of each library. Newer releases still accept the old name of a renamed one."""

WEB_ENGINE_PACKAGES = {
    "libXcomposite.so.1": "libxcomposite1",
    "libXdamage.so.1": "libxdamage1",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXrandr.so.2": "libxrandr2",
    "libXrender.so.1": "libxrender1",
    "libXtst.so.6": "libxtst6",
    "libasound.so.2": "libasound2",
    "libdrm.so.2": "libdrm2",
    "libgbm.so.1": "libgbm1",
    "libnspr4.so": "libnspr4",
    "libnss3.so": "libnss3",
    "libnssutil3.so": "libnss3",
    "libplc4.so": "libnspr4",
    "libplds4.so": "libnspr4",
    "libsmime3.so": "libnss3",
    "libudev.so.1": "libudev1",
    "libxcb-dri3.so.0": "libxcb-dri3-0",
    "libxkbfile.so.1": "libxkbfile1",
}
"""The Debian package of each library for Qt's web engine."""
RENAMED_DEBIAN_PACKAGES = {"libasound2": "libasound2t64"}
"""Packages with an old name that newer releases no longer accept."""


def missing_libraries(files: Iterable[Path]) -> set[str]:
    """Return the names of libraries of compiled files that the dynamic linker does not find."""
    names = [str(file) for file in files]
    if not names or shutil.which("ldd") is None:  # not a usual Linux: the import will show it
        return set()
    said = subprocess.run(["ldd", *names], capture_output=True, text=True).stdout
    return set(re.findall(r"^\s*(\S+) => not found", said, re.MULTILINE))


def packages_of(libraries: Iterable[str]) -> list[str]:
    """Return the known Debian packages of libraries."""
    known = DEBIAN_PACKAGES | WEB_ENGINE_PACKAGES
    return sorted({known[name] for name in libraries if name in known})


def library_advice(libraries: Iterable[str]) -> str:
    """Return advice on missing libraries, as the end of a sentence."""
    missing = sorted(libraries)
    packages = packages_of(missing)
    if not packages:
        return f"install the packages that hold them (`apt-file search {missing[0]}` names one)"
    return f"run `sudo apt-get install {' '.join(packages)}`, or your system's names for these"


def platform_names(environment: Mapping[str, str] = os.environ) -> list[str]:
    """Return the Qt platforms that may be used: the requested one, else those of the screens."""
    asked = environment.get("QT_QPA_PLATFORM")
    if asked:
        return [part.split(":")[0] for part in asked.split(";")]
    screens = {"DISPLAY": "xcb", "WAYLAND_DISPLAY": "wayland"}
    return [screens[name] for name in screens if environment.get(name)] or ["offscreen"]


def platform_plugins(environment: Mapping[str, str] = os.environ) -> list[Path]:
    """Return the existing files of the Qt platforms that may be used."""
    chosen = [_platforms() / f"libq{platform}.so" for platform in platform_names(environment)]
    return [plugin for plugin in chosen if plugin.exists()]


def known_platforms() -> list[str]:
    """Return the names of Qt's platforms, none if its plugins are elsewhere."""
    return sorted(path.stem.removeprefix("libq") for path in _platforms().glob("libq*.so"))


def _platforms() -> Path:
    return package_folder("PyQt6") / "Qt6" / "plugins" / "platforms"


def package_folder(package: str) -> Path:
    """Return the folder of a Python package, without importing it.

    Raises:
        ModuleNotFoundError: if it is not installed.
    """
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"{package} is not installed")
    return Path(spec.origin).parent
