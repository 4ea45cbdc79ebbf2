"""The scripted server of the link's tests."""

import importlib.util
from pathlib import Path

_path = Path(__file__).parents[2] / "link" / "conftest.py"
_spec = importlib.util.spec_from_file_location("link_conftest", _path)
_module = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_module)

fakes = _module.fakes
server = _module.server
