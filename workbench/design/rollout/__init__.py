"""Many step flights at once: the law that flies around a rigid body, all of it compiled."""

from workbench.common.optional_package import require_package

require_package("numba", "compiled flights (sweeps, searches, batches, predictions)")
