"""Check that the system libraries which PyQt6 and Drake link to are there; run by .venv's Python.

What is checked is what the Qt platform in use needs: a machine without a screen is not asked for
X11's libraries.
"""

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path

from apt import install, leave

PACKAGES = {
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
"""The Debian package of each library. Newer releases that renamed one still know the old name."""


def main():
    """Install what is missing, or leave with a sentence."""
    missing = _missing()
    if not missing:
        return
    unknown = sorted(missing - PACKAGES.keys())
    if unknown:
        leave(
            f"The system libraries {', '.join(unknown)} are missing: install the packages that "
            f"hold them (`apt-file search {unknown[0]}` names one), then run make again."
        )
    names = ", ".join(sorted(missing))
    install({PACKAGES[name] for name in missing}, f"System libraries are missing ({names})")
    still = sorted(_missing())
    if still:
        leave(f"The system libraries {', '.join(still)} are still missing after the install.")


def _missing():
    """Return the names of the libraries that the dynamic linker does not find."""
    if shutil.which("ldd") is None:  # not Linux as we know it: the import will tell
        return set()
    said = subprocess.run(["ldd", *_files()], capture_output=True, text=True).stdout
    return set(re.findall(r"^\s*(\S+) => not found", said, re.MULTILINE))


def _files():
    """Return the compiled files whose libraries stand for all that we use."""
    qt = _folder("PyQt6")
    modules = [next(qt.glob(f"{name}.*so")) for name in ("QtWidgets", "QtNetwork", "QtSvg")]
    plugins = qt / "Qt6" / "plugins" / "platforms"
    chosen = [plugins / f"libq{platform}.so" for platform in _platforms()]
    drake = next((_folder("pydrake") / "lib").glob("libdrake.so*"))
    return [*modules, *(plugin for plugin in chosen if plugin.exists()), drake]


def _platforms():
    """Return the Qt platforms that may be used: the one asked for, else those of the screens."""
    asked = os.environ.get("QT_QPA_PLATFORM")
    if asked:
        return [part.split(":")[0] for part in asked.split(";")]
    screens = {"DISPLAY": "xcb", "WAYLAND_DISPLAY": "wayland"}
    return [screens[name] for name in screens if os.environ.get(name)] or ["offscreen"]


def _folder(package):
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        leave(f"{package} is not in .venv: run `make clean`, then make again.")
    return Path(spec.origin).parent


if __name__ == "__main__":
    main()
