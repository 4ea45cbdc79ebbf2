"""Gains of the law `soft` in files with lines NAME=VALUE."""

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain_text
from workbench.control.controller_file import load_controller
from workbench.gains.formats import ExportedGains, GainFormat, ImportedGains, unsafe_reason


class Sheet(GainFormat):
    """The format."""

    def count_lines(self, path):
        """Return how many lines set a gain of the law."""
        names = [row.name for row in self.rows(load_controller("soft"))]
        return sum(line.partition("=")[0] in names for line in self._lines(path))

    def read(self, path, version, profile, law, *, named):
        """Return the gains in a file."""
        law = law or load_controller("soft")
        rows = {row.name: row for row in self.rows(law)}
        values, unsafe = {}, {}
        for number, line in enumerate(self._lines(path), start=1):
            name, _, text = line.partition("=")
            try:
                value = float(text)
                reason = unsafe_reason(rows[name], value)
            except (KeyError, ValueError):
                raise WorkbenchError(f"{path}:{number}: write a gain as p_tilt=150") from None
            if reason:
                unsafe[name] = reason
            else:
                values[name] = value
        return ImportedGains(firmware=self, law=law, values=values, unsafe=unsafe)

    def write(self, values, law, version, present):
        """Return a file with all gains."""
        lines = [f"{row.name}={values[row.name]:g}\n" for row in self.rows(law)]
        return ExportedGains(text="".join(lines))

    def _lines(self, path):
        return read_plain_text(path, 100_000).splitlines()


SHEET = Sheet("sheet", ("soft",), (".sheet",))
