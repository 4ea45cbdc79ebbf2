"""Check that the system libraries which PyQt6 and Drake link to are there; run by .venv's Python.

What is checked is what the Qt platform in use needs: a machine without a screen is not asked for
X11's libraries. What the embedded 3-D view needs besides is wanted where there is a screen, and
may be missing: the app then opens that view in the browser.
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
"""The same for Qt's web engine."""
RENAMED = {"libasound2": "libasound2t64"}
"""Packages whose old name newer releases know no longer."""
WITHOUT = "The 3-D view opens in the browser until {} can be found; all else works."


def main():
    """Install what is missing, or leave with a sentence."""
    _require(_missing(_files()))
    if "offscreen" not in _platforms():
        _wish_for(_missing(_web_engine_files()))


def _require(missing):
    """Install what nothing runs without, or leave with a sentence."""
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
    still = sorted(_missing(_files()))
    if still:
        leave(f"The system libraries {', '.join(still)} are still missing after the install.")


def _wish_for(missing):
    """Install what the embedded 3-D view needs, or say that it is missing."""
    if not missing:
        return
    names = ", ".join(sorted(missing))
    known = {WEB_ENGINE_PACKAGES[name] for name in missing & WEB_ENGINE_PACKAGES.keys()}
    try:
        if known:
            install({_present_name(package) for package in known}, f"The 3-D view lacks {names}")
    except SystemExit:  # what to install has been said
        pass
    still = sorted(_missing(_web_engine_files()))
    if still:
        print(WITHOUT.format(", ".join(still)), flush=True)


def _present_name(package):
    """Return the name that this release has for a package."""
    renamed = RENAMED.get(package)
    if renamed is None or shutil.which("apt-cache") is None:
        return package
    known = subprocess.run(["apt-cache", "show", renamed], capture_output=True).returncode == 0
    return renamed if known else package


def _missing(files):
    """Return the names of the libraries that the dynamic linker does not find."""
    if not files or shutil.which("ldd") is None:  # not Linux as we know it: the import will tell
        return set()
    said = subprocess.run(["ldd", *files], capture_output=True, text=True).stdout
    return set(re.findall(r"^\s*(\S+) => not found", said, re.MULTILINE))


def _files():
    """Return the compiled files whose libraries stand for all that we use."""
    qt = _folder("PyQt6")
    modules = [next(qt.glob(f"{name}.*so")) for name in ("QtWidgets", "QtNetwork", "QtSvg")]
    plugins = qt / "Qt6" / "plugins" / "platforms"
    chosen = [plugins / f"libq{platform}.so" for platform in _platforms()]
    drake = next((_folder("pydrake") / "lib").glob("libdrake.so*"))
    return [*modules, *(plugin for plugin in chosen if plugin.exists()), drake]


def _web_engine_files():
    """Return the compiled files of Qt's web engine, none where it is not installed."""
    qt = _folder("PyQt6")
    modules = list(qt.glob("QtWebEngineWidgets.*so"))
    engine = list((qt / "Qt6" / "lib").glob("libQt6WebEngineCore.so.*"))
    return [*modules, *engine] if modules and engine else []


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
