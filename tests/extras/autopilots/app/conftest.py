"""The fixtures of the core's tests of the app."""

from tests.gui.conftest import *  # noqa: F403
from tests.gui.gains.conftest import new_view, rig  # noqa: F401
from tests.gui.tuning.conftest import (  # noqa: F401
    flying,
    gains,
    judge,
    make_loop,
    offline,
    predict,
    settle,
    subject,
    trial,
)
