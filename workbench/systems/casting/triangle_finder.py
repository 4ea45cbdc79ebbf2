"""Which triangle each ray meets first: by embree, or without it by trying all.

embree has no wheels for Linux on ARM, and only an extra of the workbench brings it.
"""

import logging
from collections.abc import Callable
from functools import partial

import numpy as np

from workbench.common.optional_package import has_package, install_command
from workbench.systems.casting.surfaces import Rays, Surface, compiled_nearest_triangles

MAX_SILENT_TRIANGLES = 1000
"""Number of triangles from which on trying all of them is slow enough for a warning."""


FindTriangles = Callable[[Rays], tuple[np.ndarray, np.ndarray]]
"""Returns the number of the triangle that each ray meets, -1 for none, and its distance from where
the ray begins [m], both (m)."""


def triangle_finder(surface: Surface) -> FindTriangles:
    """Return what finds triangles of a surface on this machine."""
    if has_package("embreex"):
        return _embree_finder(surface)
    if len(surface.corners) > MAX_SILENT_TRIANGLES:
        logging.getLogger("workbench").warning(
            "rays are cast against %d triangles one by one, which is slow: `%s` brings embreex, "
            "where it has wheels",
            len(surface.corners),
            install_command("embreex"),
        )
    return partial(compiled_nearest_triangles, surface.corners)


def _embree_finder(surface: Surface) -> FindTriangles:
    """Return what asks embree's tree of the triangles; it computes in single precision."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore import EmbreeDevice
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(EmbreeDevice(), robust=True)
    vertices = np.empty((len(surface.first) - 1, 3), dtype=np.float32)
    vertices[surface.vertices] = surface.corners
    TriangleMesh(scene, vertices, surface.vertices.astype(np.int32))
    # embree builds its tree at the first ray: now, and not in flight.
    ray = np.ones((1, 3), dtype=np.float32)
    scene.run(ray, ray)

    def find(rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        found = scene.run(rays.origins, rays.directions, dists=rays.reach, output=1)
        return found["primID"], found["tfar"]

    return find
