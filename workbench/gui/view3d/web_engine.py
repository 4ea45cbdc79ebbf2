"""The web engine of the 3-D view: its environment, its graphics device, and how it is loaded."""

import importlib
import os
import re
from collections.abc import Callable, Iterable, MutableMapping
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.common.system_libraries import library_advice

CHROMIUM_FLAGS_VARIABLE = "QTWEBENGINE_CHROMIUM_FLAGS"
NO_SANDBOX_FLAG = "--no-sandbox"
"""Chromium refuses to run as root without this option."""
ANY_GPU_FLAG = "--ignore-gpu-blocklist"
"""Without this option a machine without a graphics processor shows nothing instead of slow
pictures."""
SMALL_HEAP_FLAG = "--js-flags=--initial-old-space-size=16"
"""Size [MB] up to which JavaScript's heap grows before its first garbage collection.

V8's default is hundreds: each message to the page and each picture leave garbage, and the page grew
by 40 MB a minute. This is not a limit: a heap with more data grows further.
"""
FORCE_GBM_VARIABLE = "QTWEBENGINE_FORCE_USE_GBM"
RENDER_NODES = Path("/dev/dri")
WEB_WIDGETS_MODULE = "PyQt6.QtWebEngineWidgets"
WEB_CORE_MODULE = "PyQt6.QtWebEngineCore"
PAGE_SCRIPT_FILE = Path(__file__).with_name("page.js")
_SHARED_LIBRARY = re.compile(r"(lib\S+?\.so[.\d]*)")


def load_web_view() -> Callable[[], Any]:
    """Return the factory of web views, whose pages run our script.

    Raises:
        WorkbenchError: if it is not installed, or a system library that it needs is missing.
    """
    prepare_web_engine(
        os.environ, is_root=os.geteuid() == 0, draws=can_use_gpu(RENDER_NODES.glob("renderD*"))
    )
    try:
        module = importlib.import_module(WEB_WIDGETS_MODULE)
        core = importlib.import_module(WEB_CORE_MODULE)
    except ModuleNotFoundError as error:
        raise WorkbenchError(
            "The 3-D view needs PyQt6-WebEngine, which is not installed: run "
            "`python -m pip install PyQt6-WebEngine`, then start again."
        ) from error
    except ImportError as error:
        raise WorkbenchError(missing_library(str(error))) from error

    def make() -> Any:
        view = module.QWebEngineView()
        script = core.QWebEngineScript()
        script.setSourceCode(PAGE_SCRIPT_FILE.read_text(encoding="utf-8"))
        script.setInjectionPoint(core.QWebEngineScript.InjectionPoint.DocumentCreation)
        script.setWorldId(core.QWebEngineScript.ScriptWorldId.MainWorld)
        view.page().scripts().insert(script)
        return view

    return make


def prepare_web_engine(
    environment: MutableMapping[str, str], *, is_root: bool, draws: bool
) -> None:
    """Prepare the environment for the web engine, before it is loaded; the user's values stay.

    Without a graphics processor, as in Xvfb, containers and most virtual machines, Qt still assumes
    that buffers can be shared with one (GBM) if OpenGL works, and the page stays white. With the
    right setting it draws with the processor alone.

    Args:
        environment: environment of this process.
        is_root: whether it runs as root.
        draws: whether there is a graphics processor.
    """
    flags = environment.get(CHROMIUM_FLAGS_VARIABLE, "").split()
    names = {flag.partition("=")[0] for flag in flags}
    wanted = [ANY_GPU_FLAG, SMALL_HEAP_FLAG, *([NO_SANDBOX_FLAG] if is_root else [])]
    environment[CHROMIUM_FLAGS_VARIABLE] = " ".join(
        [*flags, *(each for each in wanted if each.partition("=")[0] not in names)]
    )
    if not draws:
        environment.setdefault(FORCE_GBM_VARIABLE, "0")


def can_use_gpu(nodes: Iterable[Path]) -> bool:
    """Return whether one of these graphics devices can be used."""
    return any(os.access(node, os.R_OK | os.W_OK) for node in nodes)


def missing_library(said: str) -> str:
    """Return a sentence about the library that the system lacks, from the linker's message."""
    found = _SHARED_LIBRARY.search(said)
    if not found:
        return f"The 3-D view cannot be loaded: {said}."
    return (
        f"The 3-D view needs the system library {found[1]}, which is missing: "
        f"{library_advice([found[1]])}, then start again."
    )
