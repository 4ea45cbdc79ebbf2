"""Reports as one HTML page: its frame, its style, and its tables."""

from collections.abc import Iterable, Mapping, Sequence

from workbench.common.plain_text import html_text

_PAGE_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 62em; margin: 2em auto;
       padding: 0 1em; } body.wide { max-width: none; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin: 1.6em 0 .3em; }
table { border-collapse: collapse; margin: .5em 0 1.5em; }
th, td { text-align: left; padding: .18em .9em .18em 0; border-bottom: 1px solid #e4e4e4;
         vertical-align: top; }
.number { text-align: right; font-variant-numeric: tabular-nums; }
tr.changed { font-weight: 600; }
.failed { color: #b3261e; font-weight: 600; } .passed { color: #1b6e3c; }
.note { color: #666; } summary { cursor: pointer; }
img, svg { max-width: 100%; height: auto; } a { color: inherit; }
"""


def html_page(title: str, body: str, heading: str = "", *, wide: bool = False) -> str:
    """Return a page that needs no other file.

    Args:
        title: a text, which becomes HTML here.
        body: HTML.
        heading: HTML of the first line; "" for the title.
        wide: whether it takes the width of the window, for large pictures and tables.
    """
    name = html_text(title)
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{name}</title>
<meta name="viewport" content="width=device-width"><style>{_PAGE_STYLE}</style></head>
<body{' class="wide"' if wide else ""}>
<h1>{heading or name}</h1>
{body}
</body>
</html>
"""


def html_table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    kinds: Mapping[int, str] | None = None,
    failed: str = "",
) -> str:
    """Return a table of texts, which become HTML here.

    Args:
        head: names of the columns; empty for none.
        rows: of cells.
        kinds: of columns and their heads, by index: "number", at the right, or "note", in grey.
        failed: text of cells to show as failed.
    """
    of_column = kinds or {}

    def line(tag: str, cells: Sequence[str]) -> str:
        found = []
        for column, text in enumerate(cells):
            kind = "failed" if text and text == failed else of_column.get(column, "")
            shown = f' class="{kind}"' if kind else ""
            found.append(f"<{tag}{shown}>{html_text(text)}</{tag}>")
        return f"<tr>{''.join(found)}</tr>"

    lines = [line("th", head)] if head else []
    return f"<table>{''.join([*lines, *(line('td', row) for row in rows)])}</table>"
