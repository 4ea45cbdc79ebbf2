"""Arguments that a xacro file declares, and the error that says which of them need a value."""

from dataclasses import dataclass

from workbench.common.errors import WorkbenchError

_MOST_NAMED = 40


@dataclass(frozen=True)
class XacroArgument:
    """An argument of a xacro file.

    Attributes:
        name: of the argument.
        default: as the file writes it, None where it needs a value.
    """

    name: str
    default: str | None = None


class MissingArgumentsError(WorkbenchError):
    """A xacro file that cannot be expanded without more values, said for the command line.

    Args:
        path: of the file.
        arguments: that it takes, those that need a value first.
    """

    def __init__(self, path: str, arguments: tuple[XacroArgument, ...]) -> None:
        needed = [f"--arg {each.name}:=…" for each in arguments if each.default is None]
        more = f" and {len(needed) - _MOST_NAMED} more" if len(needed) > _MOST_NAMED else ""
        super().__init__(
            f"{path}: has arguments without a default: give {' '.join(needed[:_MOST_NAMED])}{more}"
        )
        self.arguments = arguments
