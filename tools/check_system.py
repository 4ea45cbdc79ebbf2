"""Check that the system libraries which PyQt6 and Drake link to are there; run by .venv's Python.

What is checked is what the Qt platform in use needs: a machine without a screen is not asked for
X11's libraries. What the embedded 3-D view needs besides is wanted where there is a screen, and
may be missing: the app then opens that view in the browser.
"""

import shutil
import subprocess
import sys

from apt import install, leave

from workbench.common.system_libraries import (
    DEBIAN_PACKAGES,
    RENAMED_DEBIAN_PACKAGES,
    missing_libraries,
    package_folder,
    packages_of,
    platform_names,
    platform_plugins,
)

WITHOUT = "The 3-D view opens in the browser until {} can be found; all else works."


def main():
    """Install what is missing, or leave with a sentence; on macOS the wheels have all."""
    if sys.platform == "darwin":
        return
    _require(missing_libraries(_files()))
    if "offscreen" not in platform_names():
        _wish_for(missing_libraries(_web_engine_files()))


def _require(missing):
    """Install what nothing runs without, or leave with a sentence."""
    if not missing:
        return
    unknown = sorted(missing - DEBIAN_PACKAGES.keys())
    if unknown:
        leave(
            f"The system libraries {', '.join(unknown)} are missing: install the packages that "
            f"hold them (`apt-file search {unknown[0]}` names one), then run make again."
        )
    names = ", ".join(sorted(missing))
    install({DEBIAN_PACKAGES[name] for name in missing}, f"System libraries are missing ({names})")
    still = sorted(missing_libraries(_files()))
    if still:
        leave(f"The system libraries {', '.join(still)} are still missing after the install.")


def _wish_for(missing):
    """Install what the embedded 3-D view needs, or say that it is missing."""
    if not missing:
        return
    names = ", ".join(sorted(missing))
    known = packages_of(missing)
    try:
        if known:
            install({_present_name(package) for package in known}, f"The 3-D view lacks {names}")
    except SystemExit:  # what to install has been said
        pass
    still = sorted(missing_libraries(_web_engine_files()))
    if still:
        print(WITHOUT.format(", ".join(still)), flush=True)


def _present_name(package):
    """Return the name that this release has for a package."""
    renamed = RENAMED_DEBIAN_PACKAGES.get(package)
    if renamed is None or shutil.which("apt-cache") is None:
        return package
    known = subprocess.run(["apt-cache", "show", renamed], capture_output=True).returncode == 0
    return renamed if known else package


def _files():
    """Return the compiled files whose libraries stand for all that we use."""
    qt = _folder("PyQt6")
    modules = [next(qt.glob(f"{name}.*so")) for name in ("QtWidgets", "QtNetwork", "QtSvg")]
    drake = next((_folder("pydrake") / "lib").glob("libdrake.so*"))
    return [*modules, *platform_plugins(), drake]


def _web_engine_files():
    """Return the compiled files of Qt's web engine, none where it is not installed."""
    qt = _folder("PyQt6")
    modules = list(qt.glob("QtWebEngineWidgets.*so"))
    engine = list((qt / "Qt6" / "lib").glob("libQt6WebEngineCore.so.*"))
    return [*modules, *engine] if modules and engine else []


def _folder(package):
    try:
        return package_folder(package)
    except ModuleNotFoundError:
        leave(f"{package} is not in .venv: run `make clean`, then make again.")


if __name__ == "__main__":
    main()
