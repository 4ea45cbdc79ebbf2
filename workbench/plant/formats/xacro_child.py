"""The process that expands one xacro file: run by `expand_xacro` through `run_limited`."""

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.dom import minidom

import xacro

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.ipc.limited import one_line, serve
from workbench.plant.formats.xml import MOST_BYTES, read_xml
from workbench.plant.packages import PackageFinder

_DEEPEST_INCLUDE = 50
_STAND_IN = "1"
"""A valid number, name and truth value, so that expansion continues to other missing values."""
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_QUOTE = r"(?:'|\"|&quot;|&apos;)"
_USED = re.compile(
    rf"\$\(arg\s+([^\s()${{}}]+)\s*\)|xacro\.arg\(\s*{_QUOTE}([^'\"&]+){_QUOTE}\s*\)"
)
_AROUND = re.compile(r"\$\(\s*(?:find|env|optenv)\b|xacro\.find")
"""Pattern of accesses to packages or the environment."""
_CODE = (".py", ".pyc", ".so")
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_EFFECTS = frozenset({"os", "subprocess", "socket", "shutil", "ctypes", "fcntl", "pty", "resource"})
_READS = frozenset({"os.listdir", "os.scandir", "os.walk", "os.fwalk"})


class _Args(dict[str, str]):
    """Values of arguments; a missing one gets a placeholder and is listed in `missing`."""

    def __init__(self, given: dict[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()
        self.missing: list[str] = []

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)

    def __missing__(self, name: str) -> str:
        if name not in self.missing:
            self.missing.append(name)
        return _STAND_IN


class _Reading:
    """Files and packages that xacro reads while it expands one file."""

    def __init__(self, finder: PackageFinder) -> None:
        self._finder = finder
        self._parse = xacro.parse
        self._texts: dict[str, str] = {}
        self.declared: dict[str, str] = {}
        self.used: dict[str, None] = {}
        self.read: dict[str, None] = {}
        self.looked_around = False

    def parse(self, inp: Any, filename: str | None = None) -> Any:
        """Replace `xacro.parse`: reject files that are too large, and note arguments."""
        if inp is not None or filename is None:
            return self._parse(inp, filename)
        path = Path(filename)
        if len(xacro.filestack) > _DEEPEST_INCLUDE:
            names = " -> ".join(Path(name).name for name in xacro.filestack[-3:])
            raise WorkbenchError(
                f"{path.resolve()}: is included more than {_DEEPEST_INCLUDE} deep "
                f"(... -> {names}): let no file include itself"
            )
        if len(xacro.filestack) > 1 and not _is_there(path):
            self.looked_around = True
            return self._parse(inp, filename)  # raises xacro's error
        read_xml(path)
        data = path.read_bytes()
        if filename not in self._texts:
            text = _COMMENT.sub("", data.decode(errors="replace"))
            self._texts[filename] = text
            self.looked_around |= bool(_AROUND.search(text))
            self.used |= dict.fromkeys(match[1] or match[2] for match in _USED.finditer(text))
        document = minidom.parseString(data)
        for argument in list(document.getElementsByTagName("xacro:arg")):
            name = argument.getAttribute("name")
            if argument.hasAttribute("default"):
                self.declared.setdefault(name, argument.getAttribute("default"))
            elif name and (parent := argument.parentNode):
                # xacro refuses an argument without a default; here the user is asked for a value
                self.used[name] = None
                parent.removeChild(argument)
        return document

    def find(self, name: str) -> str:
        """Return the folder for `$(find NAME)`."""
        folder = self._finder.folder(name) or self._guess(name)
        if folder is None:
            raise LookupError(
                f"package '{name}' is not found above or beside the file, nor through the "
                f"environment: {self._finder.hint(name)}"
            )
        return str(folder)

    def note(self, event: str, args: tuple[Any, ...]) -> None:
        """Act as an audit hook: reject side effects, and note the files that were read."""
        _forbid_effects(event, args)
        if event == "open" and isinstance(args[0], str) and not args[0].endswith(_CODE):
            self.read[os.path.abspath(args[0])] = None  # noqa: PTH100 - resolve() would open it
        elif event in _READS:
            self.looked_around = True

    def _guess(self, name: str) -> Path | None:
        """Return a folder with the files that are expected in an unknown package, or None.

        A description copied out of its package may still have the folders around it.
        """
        wanted = re.compile(rf"\$\(find\s+{re.escape(name)}\s*\)/([^\s\"'<>$]+)")
        for filename in reversed(xacro.filestack):
            for rest in dict.fromkeys(wanted.findall(self._texts.get(filename, ""))):
                found = self._finder.resolve(f"package://{name}/{rest}", Path(filename))
                if found is not None and found.is_file():
                    return found.parents[len(Path(rest).parts) - 1]
        return None


def expand(request: dict[str, Any]) -> dict[str, Any]:
    """Return the text for a request of `expand_xacro`, and the files that were read for it.

    The list of files is empty if the text also depends on the contents of folders, on missing
    files, or on the environment. If arguments need a value, return all that are not given instead.
    """
    path, given = Path(request["path"]), request["args"]
    reading = _Reading(PackageFinder(Path(request["source"]), request["packages"]))
    xacro.parse = reading.parse  # the one place where xacro opens XML
    _answer_find(reading.find)
    sys.addaudithook(reading.note)
    args = _Args(given)
    try:
        text = str(xacro.process_file(str(path), mappings=args).toxml())
    except WorkbenchError:
        raise
    except (Exception, SystemExit) as error:  # expressions in the file may raise any exception
        if not args.missing:  # a missing value may be the cause
            raise WorkbenchError(f"{_being_read(path)}: xacro stopped: {_reason(error)}") from error
    _check_args(path, given, args, reading)
    if args.missing:
        return {"needed": _arguments(given, args, reading)}
    if len(text.encode(errors="replace")) > MOST_BYTES:
        raise WorkbenchError(f"{path}: becomes more than {MOST_BYTES // 1_000_000} MB of URDF")
    return {"text": text, "read": [] if reading.looked_around else list(reading.read)}


def _check_args(path: Path, given: dict[str, str], args: _Args, reading: _Reading) -> None:
    """Reject unknown arguments."""
    known = reading.declared.keys() | reading.used.keys() | args.asked
    for name in given:
        if not known:
            raise WorkbenchError(f"{path}: takes no arguments, but '{name}' was given")
        if name not in known:
            raise unknown_name(f"argument of {path.name}", name, known)


def _arguments(
    given: dict[str, str], args: _Args, reading: _Reading
) -> list[tuple[str, str | None]]:
    """Return name and default of each argument that is not given, those without one first."""
    others = [name for name in reading.used if name not in reading.declared | given]
    missing = dict.fromkeys([*args.missing, *others])
    defaults = [each for each in reading.declared.items() if each[0] not in given]
    return [*((name, None) for name in missing), *defaults]


def _answer_find(find: Callable[[str], str]) -> None:
    """Let xacro call `find` for the folder of a package, instead of ROS's ament_index_python."""
    packages = ModuleType("ament_index_python.packages")
    vars(packages)["get_package_share_directory"] = find
    sys.modules["ament_index_python"] = ModuleType("ament_index_python")
    sys.modules["ament_index_python.packages"] = packages


def _forbid_effects(event: str, args: tuple[Any, ...]) -> None:
    """Reject writing files, processes and networks; expressions can escape xacro's sandbox."""
    opened_to_write = event == "open" and bool(args[2] & _WRITES)
    if opened_to_write or (event.partition(".")[0] in _EFFECTS and event not in _READS):
        raise PermissionError(f"a description may only read files ({event})")


def _being_read(path: Path) -> str:
    """Return the file that xacro was reading when it stopped, which may be an include."""
    return str(xacro.filestack[-1] if xacro.filestack else path)


def _reason(error: BaseException) -> str:
    """Return the first cause of an error, with its expression."""
    expression = ""
    while isinstance(error, xacro.XacroException) and error.exc is not None:
        expression = " ".join(str(error.suffix or "")[:300].split())
        error = error.exc
    match error:
        case MemoryError():
            text = "there is not enough memory"
        case RecursionError():
            text = "it is nested too deeply: no macro or property may depend on itself"
        case OSError(strerror=str(said), filename=str(name)):
            text = f"{said}: {name[:300]}"
        case KeyError():
            text = f"there is no {one_line(error)}"
        case _:
            text = one_line(error)
    return f"{text} {expression}".rstrip()


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # a name too long
        return False


if __name__ == "__main__":
    serve(expand)
