"""The documentation as a site: `make docs`. The pages are those of the repository, as they stand.

The README is the front page, the headings of index.md make the contents, and the reference follows
from the public names of `workbench` and their docstrings. Nothing here is needed to read the pages.
"""

import re
import sys
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import workbench  # noqa: E402

project = "Drake drone workbench"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
root_doc = "README"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs/*.md", "docs/api.rst"]
html_theme = "furo"
html_title = project
html_show_sphinx = False
html_show_copyright = False
myst_heading_anchors = 4
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True}
napoleon_numpy_docstring = False

API = ROOT / "docs" / "api.rst"
GROUPS = {
    "Fly": ("session", "live", "scenario", "setup", "diagram"),
    "Vehicles and worlds": ("plant", "common"),
    "Control laws": ("control",),
    "Gains": ("gains",),
    "Design": ("design",),
    "Logs": ("logs",),
}
"""Headings of the reference, and the rooms of `workbench` whose public names stand below them."""


def write_reference(app: Sphinx) -> None:
    """Write the reference's page: a line for each public class and function."""
    homes = {name: getattr(workbench, name) for name in workbench.__all__}
    left = {name for name, item in homes.items() if hasattr(item, "__module__")}
    lines = ["Reference", "=========", "", "What `from workbench import ...` has.", ""]
    for heading, rooms in GROUPS.items():
        lines += [heading, "-" * len(heading), ""]
        for name, item in sorted(homes.items()):
            module = getattr(item, "__module__", "") or ""
            if not module.startswith(tuple(f"workbench.{room}" for room in rooms)):
                continue
            left.discard(name)
            kind = "class" if isinstance(item, type) else "function"
            lines += [f".. auto{kind}:: {module}.{name}", ""]
    if left:
        raise ExtensionError(f"{', '.join(sorted(left))}: give the room a heading in GROUPS")
    API.write_text("\n".join(lines), encoding="utf-8")


def add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Give the front page the contents that index.md lists, for the sidebar alone.

    A folder is not a page, so a link to one becomes its name.
    """
    source[0] = re.sub(r"\[notebooks\]\((\.\./)?notebooks\)", "`notebooks/`", source[0])
    if page != root_doc:
        return
    text = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    parts = []
    for heading, body in re.findall(r"^## (.+?)\n(.*?)(?=^## |\Z)", text, re.M | re.S):
        listed = re.findall(r"^- \[[\w-]+\.md\]\(([\w-]+\.md)\)", body, re.M)
        pages = [f"docs/{name}" for name in listed]
        if heading == "The project":
            pages += ["CONTRIBUTING.md", "CHANGELOG.md"]
            pages.append("docs/api")
        if not parts:
            pages.insert(0, "docs/index.md")
        if pages:
            head = f"```{{toctree}}\n:hidden:\n:caption: {heading}\n"
            parts.append("\n".join(["", head, *pages, "```", ""]))
    source[0] += "\n" + "".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Let Sphinx call these."""
    app.add_lexer("csv", TextLexer)
    app.connect("builder-inited", write_reference)
    app.connect("source-read", add_contents)
    return {"parallel_read_safe": True}
