"""Colours and pictures of meshes for glTF: linear colours, checked and reduced pictures."""

import io

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from workbench.plant.meshes.parts import Array

_MAX_PICTURE_PIXELS = 25_000_000
"""Limit of the size of a picture; 4096 x 4096 has 17 million."""
_MAX_PICTURE_SIDE_PX = 2048
"""Largest side of a picture after reduction [pixels]."""
_MIN_OPAQUE_ALPHA = 250
"""Smallest alpha, of 255, that counts as opaque."""
_PICTURE_FORMATS = ("PNG", "JPEG", "BMP", "TGA", "GIF", "TIFF", "WEBP", "DDS")
"""Formats that Pillow reads itself; for others it may start programs."""
_PICTURE_ATTRIBUTES = (
    "baseColorTexture",
    "emissiveTexture",
    "metallicRoughnessTexture",
    "normalTexture",
    "occlusionTexture",
)


def linear_colours(color: ArrayLike) -> Array:
    """Return linear colours 0 .. 1 for sRGB colours (IEC 61966-2-1).

    COLLADA, OBJ and URDF have sRGB colours, glTF has linear ones. Alpha, an optional fourth column,
    stays unchanged.
    """
    c = np.clip(np.nan_to_num(np.asarray(color, dtype=float)), 0.0, 1.0)
    light = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    light[..., 3:] = c[..., 3:]
    return light


def vertex_colors(color: ArrayLike) -> Array:
    """Return linear colours (n, 4), 0 .. 255, for sRGB colours (n, 3 or 4), 0 .. 255.

    They are opaque: the alpha of vertices is often a leftover, and Drake's renderer does not sort
    transparent faces by depth.
    """
    light = linear_colours(np.asarray(color, dtype=float)[:, :3] / 255.0)
    return np.column_stack([np.round(255.0 * light), np.full(len(light), 255)]).astype(np.uint8)


def make_material(color: ArrayLike, picture: Image.Image | None = None) -> PBRMaterial:
    """Return a matt material.

    Args:
        color: sRGB: red, green, blue, alpha, 0 .. 1.
        picture: from `usable_picture`.
    """
    light = linear_colours(color)
    return PBRMaterial(
        baseColorFactor=light,
        baseColorTexture=picture,
        metallicFactor=0.0,
        roughnessFactor=0.8,
        doubleSided=True,  # published meshes often have inverted faces
        alphaMode="BLEND" if light[3] < 1.0 or _is_translucent(picture) else "OPAQUE",
    )


def material_of(found: PBRMaterial | SimpleMaterial) -> PBRMaterial | None:
    """Return the material for one of trimesh; None if that is only its default."""
    if isinstance(found, SimpleMaterial):
        picture = usable_picture(found.image)
        if picture is not None:
            return make_material((1.0, 1.0, 1.0, 1.0), picture)
        if "kd" not in found.kwargs:
            return None
        return make_material((*np.divide(found.diffuse[:3], 255.0), _dissolve(found)))
    pictures = {name: usable_picture(getattr(found, name)) for name in _PICTURE_ATTRIBUTES}
    return PBRMaterial(
        baseColorFactor=found.baseColorFactor,
        metallicFactor=found.metallicFactor,
        roughnessFactor=found.roughnessFactor,
        emissiveFactor=found.emissiveFactor,
        alphaMode=found.alphaMode,
        alphaCutoff=found.alphaCutoff,
        doubleSided=True,
        **pictures,
    )


def _dissolve(found: SimpleMaterial) -> float:
    """Return the opacity in an MTL file; some exporters write 0 for 1."""
    try:
        opaque = float(found.kwargs["d"][0])
    except (KeyError, IndexError, ValueError):
        return 1.0
    return opaque if 0.0 < opaque < 1.0 else 1.0


def without_pictures(material: PBRMaterial) -> PBRMaterial:
    """Return a material without pictures, for a part without texture coordinates."""
    if all(getattr(material, name) is None for name in _PICTURE_ATTRIBUTES):
        return material
    plain = material.copy()
    for name in _PICTURE_ATTRIBUTES:
        setattr(plain, name, None)
    return plain


def open_picture(data: bytes) -> Image.Image | None:
    """Return the picture in the content of a file, None if it is not supported."""
    try:
        return usable_picture(Image.open(io.BytesIO(data), formats=_PICTURE_FORMATS))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None


def usable_picture(picture: Image.Image | None) -> Image.Image | None:
    """Return a loaded and reduced picture, None if it cannot be read."""
    if picture is None or picture.format not in _PICTURE_FORMATS:
        return None
    if picture.width * picture.height > _MAX_PICTURE_PIXELS:
        return None
    try:
        picture.draft("RGB", (_MAX_PICTURE_SIDE_PX, _MAX_PICTURE_SIDE_PX))
        plain = picture.convert("RGBA" if picture.has_transparency_data else "RGB")
    except (OSError, ValueError, SyntaxError):
        return None
    plain.thumbnail((_MAX_PICTURE_SIDE_PX, _MAX_PICTURE_SIDE_PX))
    plain.format = picture.format if plain.mode == "RGB" else None  # a JPEG stays a JPEG
    return plain


def _is_translucent(picture: Image.Image | None) -> bool:
    if picture is None or picture.mode != "RGBA":
        return False
    return bool(np.asarray(picture.getchannel("A")).min() < _MIN_OPAQUE_ALPHA)
