"""The meshes among the assets of an MJCF file: as shapes, and as bodies."""

from pathlib import Path, PurePosixPath

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mesh_inertia import (
    MESH_INERTIA_MODES,
    MeshInertia,
    mesh_inertia,
    read_triangles,
)
from workbench.extras.formats.mjcf_document import MjcfDocument
from workbench.extras.formats.mjcf_elements import attribute_fault, elements_of, keyword_attribute
from workbench.extras.formats.mjcf_pose import pose_of
from workbench.plant.drawable import MeshUse, convert_meshes
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.packages import PackageFinder
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere


class Meshes:
    """The meshes by name.

    Args:
        document: with the assets.
        finder: of files.
    """

    def __init__(self, document: MjcfDocument, finder: PackageFinder) -> None:
        self._compiler = compiler = document.compiler
        self._elements: dict[str, Element] = {}
        self._shapes: dict[str, Mesh] = {}
        self._inertias: dict[str, MeshInertia] = {}
        self._files: dict[MeshUse, Path | WorkbenchError] = {}
        for asset in elements_of(document.root, "asset", "mesh"):
            element = document.defaults.applied(asset, "")
            file = element.get("file", "")
            name = element.get("name") or PurePosixPath(file).stem
            inner = PurePosixPath(file).name if compiler.strippath else file
            found = finder.resolve(str(PurePosixPath(compiler.meshdir) / inner), document.path)
            scale = attribute_triple(element, "scale", "1 1 1")
            self._elements[name] = element
            self._shapes[name] = Mesh(file, found if file else None, scale)

    def shape(self, geom: Element) -> tuple[RigidTransform, Mesh]:
        """Return the mesh of a geom, and its pose in the frame that the pose of the geom is of.

        Raises:
            WorkbenchError: if there is no such mesh.
        """
        element, mesh = self._asset(geom)
        X = pose_of(_reference(element), self._compiler).inverse()
        scale = np.array(mesh.scale)
        if np.ptp(scale) > 0.0 and not X.rotation().IsNearlyIdentity():
            raise attribute_fault(
                element, "refquat", "with a scale that is not uniform, turn the file"
            )
        return RigidTransform(X.rotation(), scale * X.translation()), mesh

    def inertia(self, geom: Element) -> MeshInertia:
        """Return the mesh of a geom as a homogeneous body, in the frame of its pose.

        Raises:
            WorkbenchError: if it cannot be computed.
        """
        element, _ = self._asset(geom)
        name = geom.get("mesh", "")
        if name not in self._inertias:
            try:
                self._inertias[name] = self._computed(name, element)
            except WorkbenchError as error:
                raise WorkbenchError(
                    f"{element_location(geom)}: <geom>: the mass of its body is made from the mesh "
                    f"'{shortened_text(name)}', and that cannot be: {error}: give the body an "
                    "<inertial>"
                ) from error
        return self._inertias[name]

    def fitted(self, geom: Element, kind: str) -> tuple[RigidTransform, GeometryShape]:
        """Return the shape that is fitted to the mesh of a geom, and its pose (mjCMesh::FitGeom).

        Raises:
            WorkbenchError: if the mesh cannot be read.
        """
        mesh = self.inertia(geom)
        scale = attribute_number(geom, "fitscale", "1")
        middle = np.zeros(3)
        x, y, z = mesh.half_box.tolist()
        if self._compiler.fitaabb:
            middle = mesh.corners.mean(axis=0)
            x, y, z = (mesh.corners[1] - middle).tolist()
            radius = max(x, y)
            ball = max(x, y, z)
            rest = z - radius
        else:
            radius = 0.5 * (x + y)
            ball = (x + y + z) / 3.0
            rest = max(0.0, z - 0.5 * radius)
        X = RigidTransform(RotationMatrix(mesh.R), mesh.p + mesh.R @ middle)
        match kind:
            case "sphere":
                return X, Sphere(scale * ball)
            case "capsule":
                return X, Capsule(scale * radius, 2.0 * scale * rest)
            case "cylinder":
                return X, Cylinder(scale * radius, 2.0 * scale * z)
            case "box":
                return X, Box((2.0 * scale * x, 2.0 * scale * y, 2.0 * scale * z))
        return X, Ellipsoid((scale * x, scale * y, scale * z))

    def _asset(self, geom: Element) -> tuple[Element, Mesh]:
        name = geom.get("mesh", "")
        if name not in self._elements:
            raise WorkbenchError(
                f"{element_location(geom)}: <geom>: there is no mesh '{shortened_text(name)}' "
                "among its assets"
            )
        return self._elements[name], self._shapes[name]

    def _computed(self, name: str, element: Element) -> MeshInertia:
        mode = keyword_attribute(element, "inertia", self._usual, " ".join(MESH_INERTIA_MODES))
        if mode == "convex" and attribute_number(element, "maxhullvert", "-1") > 0.0:
            raise WorkbenchError("a hull with a limit of vertices (maxhullvert) is not known")
        vertices, faces = self._triangles(name, element)
        X = pose_of(_reference(element), self._compiler)
        scale = np.array(self._shapes[name].scale)
        moved = ((vertices - X.translation()) @ X.rotation().matrix()) * scale
        if np.prod(scale) < 0.0:
            faces = faces[:, ::-1]
        return mesh_inertia(moved, faces, mode)

    @property
    def _usual(self) -> str:
        return "exact" if self._compiler.exactmeshinertia else "legacy"

    def _triangles(self, name: str, element: Element) -> tuple[np.ndarray, np.ndarray]:
        """Return vertices and faces of a mesh as in its file, or in its attributes."""
        if element.get("file"):
            if not self._files:  # all at once, as each start of the converter takes a second
                self._files = convert_meshes(map(_unscaled_use, self._shapes.values()))
            file = self._files[_unscaled_use(self._shapes[name])]
            if isinstance(file, WorkbenchError):
                raise file
            return read_triangles(file)
        if "builtin" in element.attrib or "vertex" not in element.attrib:
            raise WorkbenchError("it has no file and no vertices")
        vertices = np.array(attribute_numbers(element, "vertex", ""))
        faces = np.array(attribute_numbers(element, "face", ""), dtype=int)
        if vertices.size < 12 or vertices.size % 3 or faces.size % 3:
            raise WorkbenchError("it has four vertices or more, and faces, of three numbers each")
        if faces.size and not 0 <= faces.min() <= faces.max() < vertices.size // 3:
            raise WorkbenchError("its faces name a vertex that it does not have")
        return vertices.reshape(-1, 3), faces.reshape(-1, 3)


def _unscaled_use(mesh: Mesh) -> MeshUse:
    """Return the conversion of a mesh as it is in its file."""
    return MeshUse(Mesh(mesh.uri, mesh.path), "visual")


def _reference(element: Element) -> Element:
    """Return an element with the pose of a mesh's reference frame in its file."""
    words = {"pos": "refpos", "quat": "refquat"}
    return element.like(
        {name: element.attrib[given] for name, given in words.items() if given in element.attrib}
    )
