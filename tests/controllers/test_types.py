"""A law of a user's own is checked by its types: an editor completes what it is handed."""

import subprocess
import sys
from pathlib import Path

import pytest

from workbench.common.resources import controllers_dir

PYREFLY = Path(sys.executable).parent / "pyrefly"


@pytest.mark.parametrize(
    ("right", "wrong", "complaint"),
    [
        ("measured.v_WBcm", "measured.v_WBcm", ""),
        ("measured.v_WBcm", "measured.velocityy", "`MeasuredMotion` has no attribute `velocityy`"),
        ("vehicle.inertia", "vehicle.inertias", "`KnownBody` has no attribute `inertias`"),
        ("m_y, m_z), memory", "m_y), memory", "bad-return"),
    ],
    ids=["as shipped", "measurement", "vehicle", "wrench"],
)
def test_a_type_checker_finds_what_is_wrong_in_a_copy_of_pd(tmp_path, right, wrong, complaint):
    text = (controllers_dir() / "pd.py").read_text(encoding="utf-8")
    assert right in text
    law = tmp_path / "mine.py"
    law.write_text(text.replace(right, wrong), encoding="utf-8")
    done = subprocess.run(
        [PYREFLY, "check", "--preset", "default", "--python-interpreter-path", sys.executable, law],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert (done.returncode != 0) == bool(complaint), done.stdout
    assert complaint in done.stdout
