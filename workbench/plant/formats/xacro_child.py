"""The process that expands one xacro file: run by `expand_xacro` through `run_limited`."""

import glob
import io
import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import IO, Any
from xml.dom import minidom

import xacro
from xacro import substitution_args

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain
from workbench.ipc.limited import one_line_message, serve_one_request
from workbench.plant.formats.xacro import packages_in
from workbench.plant.formats.xacro_expressions import evaluate, type_of
from workbench.plant.formats.xml import MAX_XML_BYTES, read_xml
from workbench.plant.packages import PackageFinder

_MAX_XACRO_INCLUDE_DEPTH = 50
_PLACEHOLDER_VALUE = "1"
"""A valid number, name and truth value, so that expansion continues to other missing values."""
_COMMENT_PATTERN = re.compile(r"<!--.*?-->", re.DOTALL)
_QUOTE_PATTERN = r"(?:'|\"|&quot;|&apos;)"
_ARGUMENT_PATTERN = re.compile(
    rf"\$\(arg\s+([^\s()${{}}]+)\s*\)|xacro\.arg\(\s*{_QUOTE_PATTERN}([^'\"&]+){_QUOTE_PATTERN}\s*\)"
)
_ENVIRONMENT_PATTERN = re.compile(r"\$\(\s*(?:find|env|optenv)\b|xacro\.find")
"""Pattern of accesses to packages or the environment."""
_GLOB_PATTERN = re.compile(r"[*?\[]")


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
        return _PLACEHOLDER_VALUE


class _EvalNames(dict[str, Any]):
    """The names in `$(eval ...)`; those that are not in it are arguments, or Python's functions.

    Args:
        args: texts by name; they become numbers and truth values if they look like them.
    """

    def __init__(self, args: Mapping[str, str]) -> None:
        super().__init__(arg=self._converted)
        self._args = args

    def __missing__(self, name: str) -> Any:
        offered = xacro._global_symbols["python"]
        if name in offered and name not in self._args:
            return offered[name]
        return self._converted(name)

    def _converted(self, name: str) -> Any:
        return substitution_args.convert_value(self._args[name], "auto")


class _Reading:
    """The files that xacro reads while it expands one file, and the packages that it names.

    Args:
        roots: real paths of files and folders that it may read.
        packages: folders by name, None for one that does not exist; others are `wanted`.
    """

    def __init__(self, roots: Sequence[str], packages: Mapping[str, str | None]) -> None:
        self._parse = xacro.parse
        self._roots = [Path(root) for root in roots]
        self._packages = packages
        self._texts: dict[str, str] = {}
        self.declared: dict[str, str] = {}
        self.used: dict[str, None] = {}
        self.read: dict[str, None] = {}
        self.wanted: list[tuple[str, str, str]] = []
        self.outside: list[str] = []
        self.looked_around = False

    def parse(self, inp: Any, filename: str | None = None) -> Any:
        """Replace `xacro.parse`: reject files that are too large, and note arguments."""
        if filename is None:
            return self._parse(inp, filename)
        path = Path(filename)
        if len(xacro.filestack) > _MAX_XACRO_INCLUDE_DEPTH:
            names = " -> ".join(Path(name).name for name in xacro.filestack[-3:])
            raise WorkbenchError(
                f"{path.resolve()}: is included more than {_MAX_XACRO_INCLUDE_DEPTH} deep "
                f"(... -> {names}): let no file include itself"
            )
        if len(xacro.filestack) > 1 and not _is_there(path):
            self.looked_around = True
            return self._parse(inp, filename)  # raises xacro's error
        self._note(filename)
        read_xml(path)
        data = path.read_bytes()
        if filename not in self._texts:
            text = _COMMENT_PATTERN.sub("", data.decode(errors="replace"))
            self._texts[filename] = text
            self.looked_around |= bool(_ENVIRONMENT_PATTERN.search(text))
            self.used |= dict.fromkeys(
                match[1] or match[2] for match in _ARGUMENT_PATTERN.finditer(text)
            )
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

    def open(self, filename: str) -> IO[str]:
        """Replace `open`, which xacro calls for YAML files."""
        Path(filename).stat()  # raises what xacro expects for a missing file
        self._note(filename)
        return io.StringIO(read_plain(filename, MAX_XML_BYTES).decode())

    def find(self, name: str) -> str:
        """Return the folder for `$(find NAME)`."""
        if name not in self._packages:
            self.wanted = [
                (known, rest, filename)
                for filename, text in self._texts.items()
                for known, rest in packages_in(text)
                if known not in self._packages
            ]
            self.wanted.append((name, "", ""))
            raise LookupError(f"the folder of package '{name}'")
        folder = self._packages[name]
        if folder is None:
            raise LookupError(
                f"package '{name}' is not found above or beside the file, nor through the "
                f"environment: {PackageFinder.hint(name)}"
            )
        return folder

    def glob(self, pattern: str) -> list[str]:
        """Replace `glob.glob` for the names of included files."""
        self.looked_around = True
        self._note(_GLOB_PATTERN.split(pattern)[0].rpartition("/")[0])
        return glob.glob(pattern)  # noqa: PTH207 - a pattern, as xacro has it

    def _note(self, filename: str) -> None:
        """Note a file or folder that is read, and refuse one outside of the roots."""
        real = Path(filename).resolve()
        if not any(real.is_relative_to(root) for root in self._roots):
            self.outside.append(str(real))
            raise WorkbenchError(f"'{filename[:300]}' is outside of what may be read")
        self.read[os.path.abspath(filename)] = None  # noqa: PTH100 - links may change


def expand(request: dict[str, Any]) -> dict[str, Any]:
    """Return the text for a request of `expand_xacro`, and the files that were read for it.

    It is `lasting` if it depends on these alone, and not on contents of folders, missing files or
    the environment. If arguments need a value, return all that are not given instead; if the file
    names packages or files that are not in the request, return these.
    """
    path, given = Path(request["path"]), request["args"]
    reading = _Reading(request["roots"], request["packages"])
    args = _Args(given)
    _prepare_xacro(reading)
    try:
        text = str(xacro.process_file(str(path), mappings=args).toxml())
    except (Exception, SystemExit) as error:  # expressions in the file may raise any exception
        if reading.wanted or reading.outside:
            return {
                "wanted": reading.wanted,
                "outside": reading.outside,
                "in": _file_in_progress(path),
            }
        if isinstance(error, WorkbenchError):
            raise
        if not args.missing:  # a missing value may be the cause
            raise WorkbenchError(
                f"{_file_in_progress(path)}: xacro stopped: {_first_cause(error)}"
            ) from error
    _check_args(path, given, args, reading)
    if args.missing:
        return {"needed": _arguments(given, args, reading)}
    if len(text.encode(errors="replace")) > MAX_XML_BYTES:
        raise WorkbenchError(f"{path}: becomes more than {MAX_XML_BYTES // 1_000_000} MB of URDF")
    return {"text": text, "read": list(reading.read), "lasting": not reading.looked_around}


def _prepare_xacro(reading: _Reading) -> None:
    """Let xacro read through `reading`, and evaluate expressions without Python."""
    replaced = {
        "parse": reading.parse,  # the one place where xacro opens XML
        "open": reading.open,
        "glob": SimpleNamespace(glob=reading.glob),
        "safe_eval": evaluate,
    }
    vars(xacro).update(replaced)
    vars(substitution_args)["_eval"] = _evaluated
    offered = xacro._global_symbols["python"]
    offered["type"] = type_of
    del offered["vars"]  # names the insides of objects
    _replace_find(reading.find)


def _evaluated(text: str, context: dict[str, Any]) -> str:
    """Return the value of `$(eval ...)`; it has the arguments of the file among its names."""
    args = context.setdefault("arg", {})
    names = _EvalNames(args)
    names |= {
        name: value
        for name, value in substitution_args._eval_dict.items()
        if not name.startswith("__")
    }
    return str(evaluate(text, names))


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


def _replace_find(find: Callable[[str], str]) -> None:
    """Let xacro call `find` for the folder of a package, instead of ROS's ament_index_python."""
    packages = ModuleType("ament_index_python.packages")
    vars(packages)["get_package_share_directory"] = find
    sys.modules["ament_index_python"] = ModuleType("ament_index_python")
    sys.modules["ament_index_python.packages"] = packages


def _file_in_progress(path: Path) -> str:
    """Return the file that xacro was reading when it stopped, which may be an include."""
    return str(xacro.filestack[-1] if xacro.filestack else path)


def _first_cause(error: BaseException) -> str:
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
            text = f"there is no {one_line_message(error)}"
        case _:
            text = one_line_message(error)
    return f"{text} {expression}".rstrip()


def _is_there(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # a name too long
        return False


if __name__ == "__main__":
    serve_one_request(expand)
