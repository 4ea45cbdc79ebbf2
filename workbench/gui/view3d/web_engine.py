"""Qt's web engine, which may be missing: loaded late, as most of the app does without."""

import importlib
import os
import re
from collections.abc import Callable, Iterable, MutableMapping
from pathlib import Path

from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.system_libraries import remedy

FLAGS = "QTWEBENGINE_CHROMIUM_FLAGS"
NO_SANDBOX = "--no-sandbox"
"""Chromium refuses to run as root without it."""
ANY_GPU = "--ignore-gpu-blocklist"
"""Without it a machine that draws with its processor alone shows nothing instead of slowly."""
SMALL_HEAP = "--js-flags=--initial-old-space-size=16"
"""The size [MB] up to which JavaScript's heap grows before its garbage is first collected.

Left to itself, V8 takes hundreds: each message to the page and each picture leave garbage, and the
page grew by 40 MB a minute. This is no limit: a heap of which more is in use becomes larger.
"""
GBM = "QTWEBENGINE_FORCE_USE_GBM"
RENDER_NODES = Path("/dev/dri")
MODULE = "PyQt6.QtWebEngineWidgets"
CORE = "PyQt6.QtWebEngineCore"
SCRIPT = Path(__file__).with_name("page.js")
_LIBRARY = re.compile(r"(lib\S+?\.so[.\d]*)")


def load_web_view() -> Callable[[], QWidget]:
    """Return what makes web views, in whose pages our script runs.

    Raises:
        WorkbenchError: if it is not installed, or a library of the system that it needs is not.
    """
    prepare(os.environ, is_root=os.geteuid() == 0, draws=can_draw(RENDER_NODES.glob("renderD*")))
    try:
        module = importlib.import_module(MODULE)
        core = importlib.import_module(CORE)
    except ModuleNotFoundError as error:
        raise WorkbenchError(
            "The 3-D view needs PyQt6-WebEngine, which is not installed: run "
            "`python -m pip install PyQt6-WebEngine`, then start again."
        ) from error
    except ImportError as error:
        raise WorkbenchError(missing_library(str(error))) from error

    def make() -> QWidget:
        view: QWidget = module.QWebEngineView()
        script = core.QWebEngineScript()
        script.setSourceCode(SCRIPT.read_text(encoding="utf-8"))
        script.setInjectionPoint(core.QWebEngineScript.InjectionPoint.DocumentCreation)
        script.setWorldId(core.QWebEngineScript.ScriptWorldId.MainWorld)
        view.page().scripts().insert(script)  # type: ignore[attr-defined]
        return view

    return make


def prepare(environment: MutableMapping[str, str], *, is_root: bool, draws: bool) -> None:
    """Give the web engine what it needs, before it is loaded; what the user has set stays.

    Without a graphics processor, as in Xvfb, containers and most virtual machines, Qt takes it for
    granted all the same that buffers can be shared with one (GBM) where OpenGL works, and the page
    stays white. Told that it cannot, it draws with the processor alone.

    Args:
        environment: of this process.
        is_root: whether that runs as root.
        draws: whether there is a graphics processor.
    """
    flags = environment.get(FLAGS, "").split()
    names = {flag.partition("=")[0] for flag in flags}
    wanted = [ANY_GPU, SMALL_HEAP, *([NO_SANDBOX] if is_root else [])]
    environment[FLAGS] = " ".join(
        [*flags, *(each for each in wanted if each.partition("=")[0] not in names)]
    )
    if not draws:
        environment.setdefault(GBM, "0")


def can_draw(nodes: Iterable[Path]) -> bool:
    """Return whether one of these devices of graphics processors may be used."""
    return any(os.access(node, os.R_OK | os.W_OK) for node in nodes)


def missing_library(said: str) -> str:
    """Return a sentence on what the system lacks, of what the linker said."""
    found = _LIBRARY.search(said)
    if not found:
        return f"The 3-D view cannot be loaded: {said}."
    return (
        f"The 3-D view needs the system library {found[1]}, which is missing: "
        f"{remedy([found[1]])}, then start again."
    )
