"""Loops of a user's own functions that end: after many turns they raise a sentence.

The same check runs in Python and in machine code. No watchdog in another thread could end machine
code, which holds Python's lock.
"""

import ast
import types
from pathlib import Path

from workbench.common.errors import WorkbenchError

MAX_LOOP_TURNS = 1_000_000
"""Number of turns of the loops in one call of a function after which one counts as endless."""
_LOOP_ERROR_NAME, _TURN_COUNTER = "_does_not_end", "_turns"
_FINITE_ITERATORS = {"enumerate", "zip", "reversed", "sorted", "list", "tuple", "dict", "set"}
"""Functions whose result ends if their argument does."""


def bounded_code(text: str, file: Path) -> types.CodeType:
    """Compile a text so that each loop in its functions ends.

    Args:
        text: of the file.
        file: for messages.

    Raises:
        SyntaxError: if the text is not valid Python.
    """
    tree = _Bounded(file).visit(ast.parse(text, str(file)))
    return compile(ast.fix_missing_locations(tree), str(file), "exec")


LOOP_CHECK_NAMES = {_LOOP_ERROR_NAME: WorkbenchError}
"""Names that the compiled text uses."""


class _Bounded(ast.NodeTransformer):
    """Lets the loops of functions count their turns.

    Args:
        file: with the functions.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self._in_function = self._counts = False

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        before = self._in_function, self._counts
        self._in_function, self._counts = True, False
        self.generic_visit(node)
        if self._counts:
            at = 1 if ast.get_docstring(node, clean=False) is not None else 0
            node.body.insert(at, _lines(f"{_TURN_COUNTER} = 0", node)[0])
        self._in_function, self._counts = before
        return node

    def visit_While(self, node: ast.While) -> ast.AST:
        self.generic_visit(node)
        if self._in_function:
            self._count(node)
        return node

    def visit_For(self, node: ast.For) -> ast.AST | list[ast.stmt]:
        self.generic_visit(node)
        if not self._in_function or not isinstance(node.iter, ast.Call):
            return node
        name = node.iter.func.id if isinstance(node.iter.func, ast.Name) else ""
        if name == "range":
            return self._check_range(node, node.iter)
        if name not in _FINITE_ITERATORS:
            self._count(node)
        return node

    def _count(self, node: ast.While | ast.For) -> None:
        """Let each turn of a loop count."""
        self._counts = True
        check = (
            f"{_TURN_COUNTER} += 1\nif {_TURN_COUNTER} > {MAX_LOOP_TURNS}:\n    "
            f"{self._refusal(node)}"
        )
        node.body = [*_lines(check, node), *node.body]

    def _check_range(self, node: ast.For, called: ast.Call) -> ast.AST | list[ast.stmt]:
        """Check the length of a range before the loop over it, whose turns stay as they are."""
        if all(isinstance(each, ast.Constant) for each in called.args):
            return node
        name = f"_range_{node.lineno}_{node.col_offset}"
        make = ast.Assign([ast.Name(name, ast.Store())], called)
        check = _lines(f"if len({name}) > {MAX_LOOP_TURNS}:\n    {self._refusal(node)}", node)
        node.iter = ast.Name(name, ast.Load())
        return [ast.copy_location(make, node), *check, node]

    def _refusal(self, node: ast.stmt) -> str:
        said = f"{self._file}:{node.lineno}: does not end: it has an endless loop"
        return f"raise {_LOOP_ERROR_NAME}({said!r})"


def _lines(source: str, at: ast.stmt) -> list[ast.stmt]:
    """Return the statements of a source, each with the place of another statement."""
    found = ast.parse(source).body
    for each in (inner for statement in found for inner in ast.walk(statement)):
        if "lineno" in each._attributes:
            ast.copy_location(each, at)
    return found
