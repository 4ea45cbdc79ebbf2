"""The layout that docs/app.md shows is one."""

import re
from pathlib import Path

from workbench.gui.visualization.layouts import SPECTRUM, read_layout

PAGE = (Path(__file__).parents[2] / "docs" / "app.md").read_text(encoding="utf-8")


def test_the_layout_on_the_page_is_read(tmp_path):
    (text,) = re.findall(r"```yaml\n(version:.*?)```", PAGE, re.DOTALL)
    path = tmp_path / "page.layout.yaml"
    path.write_text(text)
    layout = read_layout(path)
    assert [chart.kind for chart in layout.charts] == [SPECTRUM, "time"]
    assert layout.signals[0].parsed.signals == ("v_x", "v_y")
