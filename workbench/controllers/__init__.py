"""Control laws, one file each, and everything that they may import, see docs/controllers.md."""

from workbench.common.parameter import State as State
from workbench.common.parameter import gain as gain
from workbench.common.vectors import Matrix3 as Matrix3
from workbench.common.vectors import Numbers as Numbers
from workbench.common.vectors import Quaternion as Quaternion
from workbench.common.vectors import Vector3 as Vector3
from workbench.common.vectors import Wrench as Wrench
from workbench.control.cascade import ACCELERATION_POINT as ACCELERATION_POINT
from workbench.control.cascade import ATTITUDE_POINT as ATTITUDE_POINT
from workbench.control.cascade import CASCADE_POINTS as CASCADE_POINTS
from workbench.control.cascade import POSITION_POINT as POSITION_POINT
from workbench.control.cascade import SETPOINT_POINT as SETPOINT_POINT
from workbench.control.cascade import TURN_POINT as TURN_POINT
from workbench.control.cascade import VELOCITY_POINT as VELOCITY_POINT
from workbench.control.cascade import loops_about as loops_about
from workbench.control.cascade import loops_along as loops_along
from workbench.control.cascade import points as points
from workbench.control.cascade import states as states
from workbench.control.compensator import compensator as compensator
from workbench.control.flight_state import attitude_matrix as attitude_matrix
from workbench.control.flight_state import level_heading as level_heading
from workbench.control.guidance import Gains as Gains
from workbench.control.guidance import KnownBody as KnownBody
from workbench.control.guidance import KnownRotor as KnownRotor
from workbench.control.guidance import KnownVehicle as KnownVehicle
from workbench.control.guidance import LawResult as LawResult
from workbench.control.guidance import LawSetpoint as LawSetpoint
from workbench.control.guidance import MeasuredMotion as MeasuredMotion
from workbench.control.guidance import Memory as Memory
from workbench.control.guidance import place_weights as place_weights
from workbench.control.guidance import position_error as position_error
from workbench.control.guidance import velocity_setpoint as velocity_setpoint
from workbench.control.law_parts import arctan2 as arctan2
from workbench.control.law_parts import attitude_error as attitude_error
from workbench.control.law_parts import between as between
from workbench.control.law_parts import clipped as clipped
from workbench.control.law_parts import cosine_sine as cosine_sine
from workbench.control.law_parts import difference as difference
from workbench.control.law_parts import integrated as integrated
from workbench.control.law_parts import moment as moment
from workbench.control.law_parts import tilted as tilted
from workbench.control.loop import Loop as Loop
from workbench.control.loop_points import Probes as Probes
from workbench.control.loop_points import probe as probe
from workbench.control.loop_points import probe3 as probe3
from workbench.control.loop_points import probe_tilt as probe_tilt
from workbench.dynamics.rigid_body import into_body as into_body
from workbench.plant.gravity import GRAVITY as GRAVITY

Scalar, Vector = float, Numbers
"""Names in earlier files, which logs contain."""
