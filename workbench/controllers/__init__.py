"""Control laws, each a file; and all that a file of a law may import, see docs/controllers.md."""

from workbench.common.parameter import State as State
from workbench.common.parameter import gain as gain
from workbench.control.compensator import compensator as compensator
from workbench.control.controller import Loop as Loop
from workbench.control.flight_state import attitude_matrix as attitude_matrix
from workbench.control.guidance import place_weights as place_weights
from workbench.control.guidance import position_error as position_error
from workbench.control.guidance import velocity_setpoint as velocity_setpoint
from workbench.control.law_parts import Scalar as Scalar
from workbench.control.law_parts import Vector as Vector
from workbench.control.law_parts import arctan2 as arctan2
from workbench.control.law_parts import attitude_error as attitude_error
from workbench.control.law_parts import clipped as clipped
from workbench.control.law_parts import cosine_sine as cosine_sine
from workbench.control.law_parts import difference as difference
from workbench.control.law_parts import integrated as integrated
from workbench.control.law_parts import moment as moment
from workbench.control.law_parts import tilted as tilted
from workbench.control.loop_points import probe as probe
from workbench.control.loop_points import probe3 as probe3
from workbench.dynamics.rigid_body import into_body as into_body
from workbench.plant.gravity import GRAVITY as GRAVITY
