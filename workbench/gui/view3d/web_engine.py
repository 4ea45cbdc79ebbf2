"""Qt's web engine, which may be missing: loaded late, as most of the app does without."""

import importlib
import os
import re
from collections.abc import Callable, MutableMapping

from PyQt6.QtWidgets import QWidget

from workbench.errors import WorkbenchError
from workbench.system_libraries import remedy

FLAGS = "QTWEBENGINE_CHROMIUM_FLAGS"
NO_SANDBOX = "--no-sandbox"
"""Chromium refuses to run as root without it."""
ANY_GPU = "--ignore-gpu-blocklist"
"""Without it a machine that draws with its processor alone shows nothing instead of slowly."""
MODULE = "PyQt6.QtWebEngineWidgets"
_LIBRARY = re.compile(r"(lib\S+?\.so[.\d]*)")


def load_web_view() -> Callable[[], QWidget]:
    """Return the class of web views.

    Raises:
        WorkbenchError: if it is not installed, or a library of the system that it needs is not.
    """
    prepare(os.environ, is_root=os.geteuid() == 0)
    try:
        module = importlib.import_module(MODULE)
    except ModuleNotFoundError as error:
        raise WorkbenchError(
            "The 3-D view needs PyQt6-WebEngine, which is not installed: run "
            "`python -m pip install PyQt6-WebEngine`, then start again."
        ) from error
    except ImportError as error:
        raise WorkbenchError(missing_library(str(error))) from error
    view: Callable[[], QWidget] = module.QWebEngineView
    return view


def prepare(environment: MutableMapping[str, str], *, is_root: bool) -> None:
    """Give the web engine the flags that it needs, before it is loaded."""
    flags = environment.get(FLAGS, "").split()
    wanted = [ANY_GPU, *([NO_SANDBOX] if is_root else [])]
    environment[FLAGS] = " ".join([*flags, *(each for each in wanted if each not in flags)])


def missing_library(said: str) -> str:
    """Return a sentence on what the system lacks, of what the linker said."""
    found = _LIBRARY.search(said)
    if not found:
        return f"The 3-D view cannot be loaded: {said}."
    return (
        f"The 3-D view needs the system library {found[1]}, which is missing: "
        f"{remedy([found[1]])}, then start again."
    )
