"""Reports as one HTML page: its frame, its style, and its tables."""

from collections.abc import Collection, Iterable, Sequence

from workbench.common.plain_text import html_text

_PAGE_STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 62em; margin: 2em auto;
       padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin: 1.6em 0 .3em; }
table { border-collapse: collapse; margin: .5em 0 1.5em; }
th, td { text-align: left; padding: .18em .9em .18em 0; border-bottom: 1px solid #e4e4e4;
         vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
tr.changed { font-weight: 600; }
.failed { color: #b3261e; font-weight: 600; } .passed { color: #1b6e3c; }
.note { color: #666; } summary { cursor: pointer; }
img, svg { max-width: 100%; height: auto; } a { color: inherit; }
"""


def html_page(title: str, body: str, heading: str = "") -> str:
    """Return a page that needs no other file.

    Args:
        title: a text, which becomes HTML here.
        body: HTML.
        heading: HTML of the first line; "" for the title.
    """
    name = html_text(title)
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{name}</title>
<meta name="viewport" content="width=device-width"><style>{_PAGE_STYLE}</style></head>
<body>
<h1>{heading or name}</h1>
{body}
</body>
</html>
"""


def html_table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    numbers: Collection[int] = (),
    failed: str = "",
) -> str:
    """Return a table of texts, which become HTML here.

    Args:
        head: names of the columns; empty for none.
        rows: of cells.
        numbers: columns to align at the right.
        failed: text of cells to show as failed.
    """

    def cell(column: int, text: str) -> str:
        kind = "number" if column in numbers else "failed" if text and text == failed else ""
        start = f'<td class="{kind}">' if kind else "<td>"
        return f"{start}{html_text(text)}</td>"

    lines = ["".join(f"<th>{html_text(text)}</th>" for text in head)] if head else []
    lines += ["".join(cell(*each) for each in enumerate(row)) for row in rows]
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>"
