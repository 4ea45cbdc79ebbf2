"""Count lines of code, classes, files and importers of the package, and list what is unused.

Example: `python tools/house.py` prints a table of the rooms; with `--single --dead` it also lists
what could be merged or deleted; `python tools/house.py --json` prints all of it for programs.

What is counted, so that figures of two days can be compared:

- A room is a folder below `workbench`, or a single file there.
- A line of code is a line with a token of Python on it. Blank lines, comments, docstrings and all
  lines of import statements are none. A docstring is any statement that is a string alone, so the
  sentence below a constant is one too. The line `if TYPE_CHECKING:` counts.
- A class is a `class` statement at the top of a module.
- A module has a single importer if at most one other module of the package imports it: at its top,
  in a function, for types only, or by `import_module` with a constant. What `from package import
  name` takes through an `__init__` is an import of the module that defines the name. An `__init__`
  is an importer as any other; itself it stands for its package and is not counted, nor is
  `__main__`. Modules without an importer are counted too: processes and plugins run them by name.
- A circle is a set of modules each of which leads to each other by imports. It is `top` if imports
  at the top of files close it, `hidden` if only imports in functions do, and `types` if only
  imports under `TYPE_CHECKING` do; `rooms` is a circle of rooms.
- An unused symbol is a public function, class, constant, method or field whose name stands nowhere
  else in the package or beside it (tests, tools, docs, notebooks, models, benchmarks, examples).
  Names are compared, not objects: two methods of one name hide each other, and what a framework
  calls by its name (as `visit_Name`) is listed though it is used. Names in mixed case, which are
  Qt's and Drake's hooks, are left out. `tests` marks what only tests use.
"""

import argparse
import ast
import io
import json
import re
import sys
import tokenize
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "workbench"
USERS = ("tests", "tools", "docs", "notebooks", "models", "benchmarks", "examples")
"""Folders beside the package whose files may use it."""
TEXTS = {".py", ".md", ".ipynb", ".yaml", ".js", ".html", ".css", ".toml", ".ini", ".xacro", ".msg"}
WORD = re.compile(r"[^\W\d]\w*")
NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
}
WORDS = {
    tokenize.NAME,
    tokenize.STRING,
    getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING),  # since Python 3.12
}
TOP, FUNCTION, TYPES = "top", "function", "types"
"""Where an import stands."""


@dataclass
class Module:
    """A file of the package.

    Attributes:
        name: full, as workbench.plant.vehicle; a package's `__init__` has the package's name.
        path: below the project's folder.
        text: of the file.
    """

    name: str
    path: Path
    text: str
    imports: dict[str, set[str]] = field(default_factory=lambda: defaultdict(set))
    """Where imports of a module stand, by the module's name."""

    @property
    def is_init(self) -> bool:
        return self.path.name == "__init__.py"

    @property
    def room(self) -> str:
        return self.folder(1)

    def folder(self, depth: int) -> str:
        """Return its folder, so many levels below the package, or itself if it is not so deep."""
        return "/".join(self.path.with_suffix("").parts[1 : depth + 1])

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text, str(self.path))

    @cached_property
    def tokens(self) -> list[tokenize.TokenInfo]:
        return list(tokenize.generate_tokens(io.StringIO(self.text).readline))

    @cached_property
    def prose(self) -> set[int]:
        """Lines of docstrings."""
        return _lines_of(
            node
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        )

    @cached_property
    def code(self) -> set[int]:
        """Lines of code."""
        imports = (n for n in ast.walk(self.tree) if isinstance(n, ast.Import | ast.ImportFrom))
        covered = {
            line
            for token in self.tokens
            if token.type not in NO_CODE
            for line in range(token.start[0], token.end[0] + 1)
        }
        return covered - self.prose - _lines_of(imports)

    @cached_property
    def words(self) -> list[tuple[str, int]]:
        """Names, and words in strings that are not docstrings, with their lines."""
        return [
            (word, token.start[0])
            for token in self.tokens
            if token.type in WORDS and token.start[0] not in self.prose
            for word in WORD.findall(token.string)
        ]

    @property
    def classes(self) -> list[ast.ClassDef]:
        return [node for node in self.tree.body if isinstance(node, ast.ClassDef)]

    @property
    def functions(self) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
        kinds = ast.FunctionDef | ast.AsyncFunctionDef
        return [node for node in ast.walk(self.tree) if isinstance(node, kinds)]

    def code_in(self, node: ast.AST) -> int:
        """Return the lines of code of a definition."""
        return len(self.code & _lines_of([node]))


@dataclass(frozen=True)
class Symbol:
    """A public name that the package defines."""

    name: str
    kind: str
    module: Module
    node: ast.AST


class House:
    """All modules of a package, and what follows from them."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.modules: dict[str, Module] = {}
        for path in sorted((root / PACKAGE).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            self.modules[name] = Module(name, path.relative_to(root), path.read_text())
        homes = {m.name: _homes(m) for m in self.modules.values() if m.is_init}
        for module in self.modules.values():
            for where, base, name in _imports(module):
                for target in self._targets(base, name, homes):
                    if target != module.name:
                        module.imports[target].add(where)

    def _targets(self, base: str, name: str, homes: dict[str, dict[str, str]]) -> Iterator[str]:
        """Yield the module that `from base import name` reads."""
        for found in (f"{base}.{name}" if name else base, homes.get(base, {}).get(name), base):
            if found in self.modules:
                yield found
                return

    def importers(self) -> dict[str, set[str]]:
        """Return who imports each module, but for packages and `__main__`."""
        found: dict[str, set[str]] = {
            module.name: set()
            for module in self.modules.values()
            if module.path.name not in ("__init__.py", "__main__.py")
        }
        for module in self.modules.values():
            for target in module.imports.keys() & found.keys():
                found[target].add(module.name)
        return found

    def single(self) -> list[tuple[Module, Module | None]]:
        """Return the modules with at most one importer, and it; the smallest first."""
        pairs = [
            (self.modules[name], self.modules[next(iter(users))] if users else None)
            for name, users in self.importers().items()
            if len(users) <= 1
        ]
        return sorted(pairs, key=lambda pair: (len(pair[0].code), pair[0].name))

    def circles(self) -> list[tuple[str, list[str]]]:
        """Return each circle: its kind, and its modules or rooms."""
        found = []
        for circle in _components(self._graph({TOP, FUNCTION, TYPES}, self.modules)):
            if _components(self._graph({TOP}, circle)):
                kind = "top"
            elif _components(self._graph({TOP, FUNCTION}, circle)):
                kind = "hidden"
            else:
                kind = "types"
            found.append((kind, sorted(circle)))
        rooms: dict[str, set[str]] = {m.room: set() for m in self.modules.values()}
        for name, targets in self._graph({TOP, FUNCTION, TYPES}, self.modules).items():
            here = self.modules[name].room
            rooms[here] |= {self.modules[target].room for target in targets} - {here}
        found += [("rooms", sorted(circle)) for circle in _components(rooms)]
        return sorted(found, key=lambda each: (each[0], len(each[1]), each[1]))

    def _graph(self, kinds: set[str], among: Iterable[str]) -> dict[str, set[str]]:
        """Return which modules each imports by these kinds of imports."""
        return {
            name: {
                target
                for target, where in self.modules[name].imports.items()
                if target in among and where & kinds
            }
            for name in among
        }

    def unused(self) -> list[tuple[Symbol, str]]:
        """Return the symbols that nobody uses, with who does: nobody, or only tests."""
        inside: dict[str, list[tuple[Module | None, int]]] = defaultdict(list)
        for module in self.modules.values():
            for word, line in module.words:
                inside[word].append((module, line))
        for path in sorted((self.root / PACKAGE).rglob("*")):
            if path.suffix in TEXTS - {".py"}:
                for word in WORD.findall(path.read_text()):
                    inside[word].append((None, 0))
        outside: dict[str, set[str]] = defaultdict(set)
        for folder, text in self._texts():
            for word in set(WORD.findall(text)):
                outside[word].add(folder)
        found = []
        for symbol in self._symbols():
            own = _lines_of([symbol.node])
            if any(m is not symbol.module or n not in own for m, n in inside[symbol.name]):
                continue
            users = outside.get(symbol.name, set())
            if users <= {"tests"}:
                found.append((symbol, "tests" if users else ""))
        return sorted(found, key=lambda each: (each[1], each[0].module.name, each[0].node.lineno))

    def _texts(self) -> Iterator[tuple[str, str]]:
        """Yield folder and text of each file beside the package."""
        for path in self.root.glob("*.*"):
            if path.suffix in TEXTS:
                yield ".", path.read_text()
        for folder in USERS:
            for path in sorted((self.root / folder).rglob("*")):
                if path.suffix in TEXTS and path.is_file():
                    yield folder, path.read_text()

    def _symbols(self) -> Iterator[Symbol]:
        for module in self.modules.values():
            if module.path.parent.name == PACKAGE and module.is_init:
                continue
            for name, kind, node in _named(module.tree):
                yield Symbol(name, kind, module, node)
                if isinstance(node, ast.ClassDef):
                    inner = {ast.FunctionDef: "method", ast.AsyncFunctionDef: "method"}
                    for member, _, part in _named(node):
                        if re.search("[a-z][A-Z]", member) or member.startswith("Do"):
                            continue
                        yield Symbol(member, inner.get(type(part), "field"), module, part)

    def rooms(self, depth: int = 1) -> dict[str, Counter[str]]:
        """Return the figures of each folder at a depth below the package."""
        found: dict[str, Counter[str]] = defaultdict(Counter)
        for module in self.modules.values():
            room = found[module.folder(depth)]
            room["code"] += len(module.code)
            room["classes"] += len(module.classes)
            room["files"] += 1
            room["lines"] += module.text.count("\n")
        for module, _ in self.single():
            found[module.folder(depth)]["single"] += 1
        return dict(found)

    def largest(self, count: int) -> dict[str, list[tuple[str, int]]]:
        """Return the largest files, classes and functions, in lines of code."""
        table = {
            "files": [(str(m.path), len(m.code)) for m in self.modules.values()],
            "classes": [(m, node) for m in self.modules.values() for node in m.classes],
            "functions": [(m, node) for m in self.modules.values() for node in m.functions],
        }
        for title in ("classes", "functions"):
            table[title] = [
                (f"{m.path}:{node.lineno} {node.name}", m.code_in(node)) for m, node in table[title]
            ]
        return {
            title: sorted(rows, key=lambda row: (-row[1], row[0]))[:count]
            for title, rows in table.items()
        }


def _components(graph: dict[str, set[str]]) -> list[set[str]]:
    """Return sets of more than one node that lead to each other (Tarjan's algorithm)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(name: str) -> None:
        index[name] = low[name] = len(index)
        stack.append(name)
        for target in graph[name]:
            if target not in index:
                visit(target)
                low[name] = min(low[name], low[target])
            elif target in stack:
                low[name] = min(low[name], index[target])
        if low[name] == index[name]:
            at = stack.index(name)
            if len(stack) - at > 1:
                found.append(set(stack[at:]))
            del stack[at:]

    for name in sorted(graph):
        if name not in index:
            visit(name)
    return found


def _lines_of(nodes: Iterable[ast.AST]) -> set[int]:
    """Return all lines of some nodes, decorators included."""
    return {
        line
        for node in nodes
        for line in range(
            min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))]),
            node.end_lineno + 1,
        )
    }


def _named(scope: ast.Module | ast.ClassDef) -> Iterator[tuple[str, str, ast.AST]]:
    """Yield name, kind and node of each public name that a scope defines."""
    for node in scope.body:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                found = [(name, "function")]
            case ast.ClassDef(name=name):
                found = [(name, "class")]
            case ast.Assign(targets=targets):
                names = (n for target in targets for n in ast.walk(target))
                found = [(n.id, "constant") for n in names if isinstance(n, ast.Name)]
            case ast.AnnAssign(target=ast.Name(id=name)):
                found = [(name, "constant")]
            case _:
                found = []
        yield from ((name, kind, node) for name, kind in found if not name.startswith("_"))


def _homes(init: Module) -> dict[str, str]:
    """Return where the names that an `__init__` hands on are at home.

    They are imported there, at once or for types, or stand in a table of names and modules.
    """
    found = {name: base for _, base, name in _imports(init) if name}
    for node in ast.walk(init.tree):
        if isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                match key, value:
                    case ast.Constant(value=str(name)), ast.Constant(value=str(module)):
                        found[name] = module
    return found


def _imports(module: Module) -> Iterator[tuple[str, str, str]]:
    """Yield where an import stands, the module and, of `from module import name`, the name."""
    package = module.name if module.is_init else module.name.rpartition(".")[0]
    todo: list[tuple[ast.AST, str]] = [(module.tree, TOP)]
    while todo:
        node, where = todo.pop()
        match node:
            case ast.Import(names=names):
                yield from ((where, alias.name, "") for alias in names)
            case ast.ImportFrom(module=base, names=names, level=level):
                start = package.split(".")[: len(package.split(".")) - level + 1] if level else []
                full = ".".join([*start, *([base] if base else [])])
                yield from ((where, full, alias.name) for alias in names)
            case ast.Call(func=func, args=[ast.Constant(value=str(name)), *_]):
                if getattr(func, "attr", getattr(func, "id", None)) == "import_module":
                    yield where, name, ""
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                where = FUNCTION
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                todo += [(child, TYPES) for child in node.body]
                todo += [(child, where) for child in node.orelse]
                continue
        todo += [(child, where) for child in ast.iter_child_nodes(node)]


COLUMNS = ("code", "classes", "single", "files", "lines")


def as_data(house: House, largest: int) -> dict:
    """Return everything for programs."""
    rooms = {name: {c: room[c] for c in COLUMNS} for name, room in sorted(house.rooms().items())}
    return {
        "total": {column: sum(room[column] for room in rooms.values()) for column in COLUMNS},
        "rooms": rooms,
        "circles": [{"kind": kind, "modules": names} for kind, names in house.circles()],
        "single": [
            {
                "file": str(module.path),
                "code": len(module.code),
                "importer": str(user.path) if user else None,
            }
            for module, user in house.single()
        ],
        "unused": [
            {
                "file": str(symbol.module.path),
                "line": symbol.node.lineno,
                "name": symbol.name,
                "kind": symbol.kind,
                "used_by": users,
            }
            for symbol, users in house.unused()
        ],
        "largest": {
            title: [{"name": name, "code": code} for name, code in rows]
            for title, rows in house.largest(largest).items()
        },
    }


def print_tables(house: House, options: argparse.Namespace) -> None:
    """Print the table of rooms, and the lists that are asked for."""
    rooms = sorted(house.rooms(options.depth).items(), key=lambda each: -each[1]["code"])
    total = sum((room for _, room in rooms), Counter())
    width = max(20, *(len(name) + 1 for name, _ in rooms))
    print(f"{'room':{width}}" + "".join(f"{column:>9}" for column in COLUMNS))
    for name, room in [*rooms, ("all", total)]:
        print(f"{name:{width}}" + "".join(f"{room[column]:9,}" for column in COLUMNS))
    circles = house.circles()
    print(f"\n{len(circles)} circles of imports")
    for kind, names in circles:
        print(f"  {kind:8}{', '.join(names)}")
    if options.single:
        print("\nmodules with one importer or none: lines of code, module, importer")
        for module, user in house.single():
            print(f"  {len(module.code):5}  {module.path}  {user.path if user else '-'}")
    if options.dead:
        print("\npublic symbols that are used nowhere, or by tests only")
        for symbol, users in house.unused():
            where = f"{symbol.module.path}:{symbol.node.lineno}"
            print(f"  {users:6}{symbol.kind:9}{symbol.name}  {where}")
    if options.largest:
        for title, rows in house.largest(options.largest).items():
            print(f"\nlargest {title}")
            for name, code in rows:
                print(f"  {code:5}  {name}")


def main() -> int:
    """Count a tree of the project."""
    description, _, rest = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(
        description=description,
        epilog=rest,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "root", nargs="?", type=Path, default=ROOT, help="folder of the project (default: this one)"
    )
    parser.add_argument(
        "--depth", type=int, default=1, help="of the counted folders below the package (default: 1)"
    )
    parser.add_argument(
        "--single", action="store_true", help="list modules with one importer or none"
    )
    parser.add_argument("--dead", action="store_true", help="list public symbols that are unused")
    parser.add_argument(
        "--largest",
        type=int,
        nargs="?",
        const=20,
        default=0,
        metavar="N",
        help="list the N largest files, classes and functions (default: 20)",
    )
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    options = parser.parse_args()
    if not (options.root / PACKAGE).is_dir():
        print(f"house: {options.root} has no folder {PACKAGE}: name the project's", file=sys.stderr)
        return 2
    house = House(options.root)
    if options.json:
        print(json.dumps(as_data(house, options.largest or 20), indent=1))
    else:
        print_tables(house, options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
