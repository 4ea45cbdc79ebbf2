"""Everything that a user's own estimator file may import, see docs/estimation.md."""

from workbench.common.parameter import State as State
from workbench.common.parameter import gain as gain
from workbench.dynamics.rigid_body import into_body as into_body
from workbench.dynamics.rigid_body import into_world as into_world
from workbench.dynamics.rigid_body import rotation as rotation
from workbench.estimation.complementary import turning as turning
from workbench.estimation.ekf import InitialDeviations as InitialDeviations
from workbench.estimation.ekf import cross as cross
from workbench.estimation.ekf import nominal as nominal
from workbench.estimation.ekf_propagation import corrected as corrected
from workbench.estimation.ekf_propagation import propagated as propagated
from workbench.estimation.ekf_propagation import turned_by as turned_by
from workbench.estimation.ekf_state import ERRORS as ERRORS
from workbench.estimation.ekf_state import NOMINAL as NOMINAL
from workbench.estimation.samples import AGES as AGES
from workbench.estimation.samples import BAROMETER as BAROMETER
from workbench.estimation.samples import GPS as GPS
from workbench.estimation.samples import MAGNETOMETER as MAGNETOMETER
from workbench.estimation.samples import RANGE_FINDER as RANGE_FINDER
from workbench.estimation.samples import Mounting as Mounting
from workbench.plant.gravity import GRAVITY as GRAVITY

crossed = cross
"""The name of the cross product in earlier files."""
