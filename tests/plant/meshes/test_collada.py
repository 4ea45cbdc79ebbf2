"""COLLADA documents written here, with bounds and colours by hand, as Gazebo would show them."""

import numpy as np
import pytest
from PIL import Image

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes import collada
from workbench.plant.meshes.collada import read_collada
from workbench.plant.meshes.mesh_file import SideFileResolver

SKIN = "<newparam sid='s'><surface type='2D'><init_from>img</init_from></surface></newparam>"
SKIN += "<newparam sid='t'><sampler2D><source>s</source></sampler2D></newparam>"
TEXTURE = "<diffuse><texture texture='t' texcoord='UV'/></diffuse>"
MATERIAL = """<bind_material><technique_common>
<instance_material symbol="m" target="#mat"/></technique_common></bind_material>"""
GEOMETRY = f"<instance_geometry url='#geo'>{MATERIAL}</instance_geometry>"
TRIANGLE = f"<node name='blade'>{GEOMETRY}</node>"


def document(
    nodes: str = TRIANGLE,
    head: str = "",
    asset: str = "",
    phong: str = "<diffuse><color>1 0 0 1</color></diffuse>",
    params: str = "",
    picture: str = "skin.png",
    library: str = "",
    effect: str = "<instance_effect url='#eff'/>",
    inputs: str = "",
    p: str = "0 1 2",
    points: str = "0 0 0 1 0 0 0 2 0",
) -> bytes:
    """A triangle with corners at 0, 1 along x and 2 along y, in the file's units."""
    return f"""<?xml version="1.0"?>{head}
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{asset}</asset>
<library_images><image id="img"><init_from>{picture}</init_from></image></library_images>
<library_effects><effect id="eff"><profile_COMMON>{params}<technique sid="c"><phong>{phong}</phong>
</technique></profile_COMMON></effect></library_effects>
<library_materials><material id="mat">{effect}</material></library_materials>
<library_geometries><geometry id="geo" name="shape"><mesh>
<source id="pos"><float_array id="pa" count="9">{points}</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<source id="col"><float_array id="ca" count="9">1 1 1 0 0 0 1 0 0</float_array><technique_common>
<accessor source="#ca" count="3" stride="3"><param name="R" type="float"/>
<param name="G" type="float"/><param name="B" type="float"/></accessor></technique_common></source>
<source id="uv"><float_array id="ua" count="6">0 0 1 0 0 1</float_array><technique_common>
<accessor source="#ua" count="3" stride="2"><param name="S" type="float"/>
<param name="T" type="float"/></accessor></technique_common></source>
<vertices id="ver"><input semantic="POSITION" source="#pos"/></vertices>
<triangles count="1" material="m"><input semantic="VERTEX" source="#ver" offset="0"/>{inputs}
<p>{p}</p></triangles></mesh></geometry></library_geometries>
<library_nodes>{library}</library_nodes>
<library_visual_scenes><visual_scene id="sc">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#sc"/></scene></COLLADA>""".encode()


@pytest.fixture
def read(tmp_path):
    """Read a document in a folder with a red picture."""
    Image.new("RGB", (2, 2), (255, 0, 0)).save(tmp_path / "skin.png")
    return lambda data: read_collada(data, SideFileResolver(tmp_path / "a.dae"))


def bounds(parts) -> list[list[float]]:
    vertices = np.vstack([part.vertices for part in parts])
    return [vertices.min(axis=0).round(6).tolist(), vertices.max(axis=0).round(6).tolist()]


@pytest.mark.parametrize(
    ("asset", "meter"),
    [
        ("", 1.0),
        ("<unit/>", 1.0),
        ("<unit meter='0.01' name='centimeter'/>", 0.01),
        ("<unit meter='0.0254' name='inch'/>", 0.0254),
    ],
)
def test_units_are_applied(read, asset, meter):
    assert bounds(read(document(asset=asset))) == [[0, 0, 0], [meter, 2 * meter, 0]]


@pytest.mark.parametrize("axis", ["X_UP", "Y_UP", "Z_UP"])
def test_the_up_axis_is_not(read, axis):
    parts = read(document(asset=f"<unit meter='0.01'/><up_axis>{axis}</up_axis>"))
    assert bounds(parts) == [[0, 0, 0], [0.01, 0.02, 0]]


@pytest.mark.parametrize("meter", ["0", "-1", "nan", "inf", "1e-400"])
def test_a_unit_that_is_no_length_is_refused(read, meter):
    with pytest.raises(WorkbenchError, match="its unit of .* m is not a length"):
        read(document(asset=f"<unit meter='{meter}'/>"))


@pytest.mark.parametrize(
    ("transforms", "low", "high"),
    [
        ("<translate>10 20 30</translate>", [10, 20, 30], [11, 22, 30]),
        ("<rotate>0 0 1 90</rotate>", [-2, 0, 0], [0, 1, 0]),
        ("<scale>2 3 4</scale>", [0, 0, 0], [2, 6, 0]),
        (
            "<translate>10 0 0</translate><rotate>1 0 0 90</rotate><scale>1 2 1</scale>",
            [10, 0, 0],
            [11, 0, 4],
        ),
        ("<matrix>1 0 0 5  0 0 -1 6  0 1 0 7  0 0 0 1</matrix>", [5, 6, 7], [6, 6, 9]),
    ],
)
def test_transforms_of_nodes_are_applied_in_their_order(read, transforms, low, high):
    parts = read(document(f"<node>{transforms}{GEOMETRY}</node>"))
    assert bounds(parts) == [low, high]


def test_nodes_stand_in_nodes_and_units_scale_them_all(read):
    inner = f"<node><rotate>0 0 1 90</rotate>{GEOMETRY}</node>"
    nodes = f"<node><translate>100 0 0</translate>{inner}</node>"
    parts = read(document(nodes, asset="<unit meter='0.01'/><up_axis>Y_UP</up_axis>"))
    assert bounds(parts) == [[0.98, 0, 0], [1.0, 0.01, 0]]


def test_a_mirroring_node_turns_faces_over(read):
    [plain] = read(document())
    [mirrored] = read(document(f"<node><scale>-1 1 1</scale>{GEOMETRY}</node>"))
    a, b, c = mirrored.vertices[mirrored.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
    a, b, c = plain.vertices[plain.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0


def test_instances_of_a_node_are_drawn_each(read):
    library = f"<node id='n' name='leaf'><translate>1 0 0</translate>{GEOMETRY}</node>"
    instance = "<instance_node url='#n'/>"
    nodes = f"<node>{instance}</node><node><translate>0 0 5</translate>{instance}</node>"
    parts = read(document(nodes, library=library))
    assert bounds(parts) == [[1, 0, 0], [2, 2, 5]]
    assert [part.names[0] for part in parts] == ["leaf", "leaf"]


@pytest.mark.parametrize(
    ("nodes", "names"),
    [
        (TRIANGLE, ("blade", "shape", "geo")),
        (f"<node name='arm'><node>{GEOMETRY}</node></node>", ("arm", "shape", "geo")),
        (f"<node name='arm'><node name='tip'>{GEOMETRY}</node></node>", ("tip", "shape", "geo")),
        (f"<node id='only'>{GEOMETRY}</node>", ("shape", "geo")),
    ],
)
def test_a_part_is_called_as_in_gazebo(read, nodes, names):
    [part] = read(document(nodes))
    assert part.names == names


def factor(part) -> list[float]:
    return np.divide(part.material.baseColorFactor, 255.0).tolist()


# On a screen 0.5, of the light 0.214 (IEC 61966-2-1).
@pytest.mark.parametrize(
    ("phong", "color"),
    [
        ("<diffuse><color>1 0.5 0 1</color></diffuse>", [1, 0.214, 0, 1]),
        ("<diffuse><color>1 0 0 0.3</color></diffuse>", [1, 0, 0, 1]),
        ("<emission><color>0 1 0 1</color></emission>", [0, 1, 0, 1]),
        ("<diffuse><color>nan 7 -1 1</color></diffuse>", [0, 1, 0, 1]),
    ],
)
def test_a_part_has_the_diffuse_colour(read, phong, color):
    [part] = read(document(phong=phong))
    assert factor(part) == pytest.approx(color, abs=0.003)  # one part in 255


@pytest.mark.parametrize(
    ("transparent", "transparency", "alpha"),
    [
        ("opaque='A_ONE'><color>1 1 1 0.5", "", 0.5),
        ("opaque='A_ONE'><color>1 1 1 0.5", "0.5", 0.25),
        ("opaque='A_ZERO'><color>1 1 1 0.25", "", 0.75),
        ("opaque='RGB_ZERO'><color>0.4 0.4 0.4 1", "", 0.6),
        ("opaque='RGB_ZERO'><color>1 1 1 1", "0", 1.0),
        ("opaque='RGB_ONE'><color>0.4 0.4 0.4 1", "", 0.4),
        ("><color>1 1 1 0.5", "0.5", 1.0),
        ("opaque='A_ONE'><color>1 1 1 nan", "", 1.0),
        ("opaque='SOME'><color>1 1 1 0.5", "", 1.0),
    ],
)
def test_opacity_is_what_the_specification_says(read, transparent, transparency, alpha):
    phong = f"<diffuse><color>1 1 1 1</color></diffuse><transparent {transparent}</color>"
    phong += "</transparent>"
    if transparency:
        phong += f"<transparency><float>{transparency}</float></transparency>"
    [part] = read(document(phong=phong))
    assert factor(part)[3] == pytest.approx(alpha, abs=0.003)
    assert part.material.alphaMode == ("OPAQUE" if alpha == 1.0 else "BLEND")


UV = "<input semantic='TEXCOORD' source='#uv' offset='1' set='0'/>"


def test_a_texture_is_read_with_its_coordinates(read):
    data = document(phong=TEXTURE, params=SKIN, inputs=UV, p="0 0 1 1 2 2")
    [part] = read(data)
    assert part.material.baseColorTexture.getpixel((0, 0)) == (255, 0, 0)
    assert sorted(map(tuple, np.hstack([part.vertices, part.uv]).tolist())) == [
        (0, 0, 0, 0, 0),
        (0, 2, 0, 0, 1),
        (1, 0, 0, 1, 0),
    ]


@pytest.mark.parametrize("picture", ["missing.png", "../../etc/skin.jpg", "", "http://a.b/c.png"])
def test_without_its_texture_a_part_has_no_colour_of_its_own(read, picture):
    data = document(phong=TEXTURE, params=SKIN, inputs=UV, p="0 0 1 1 2 2", picture=picture)
    [part] = read(data)
    assert part.material is None


COLOR = "<input semantic='COLOR' source='#col' offset='1'/>"


def test_colours_of_vertices_count_only_without_a_material(read):
    [part] = read(document(inputs=COLOR, p="0 0 1 1 2 2"))
    assert part.colors is None
    bare = "<node><instance_geometry url='#geo'/></node>"
    [part] = read(document(bare, inputs=COLOR, p="0 0 1 1 2 2"))
    assert sorted(part.colors.tolist()) == [[0, 0, 0, 255], [255, 0, 0, 255], [255, 255, 255, 255]]


@pytest.mark.parametrize(
    "effect", ["", "<instance_effect url='#none'/>", "<instance_effect url='eff.dae'/>"]
)
def test_a_broken_material_does_not_take_the_part_away(read, effect):
    [part] = read(document(effect=effect))
    assert part.material is None
    assert len(part.faces) == 1


ENTITY = '<!DOCTYPE COLLADA [<!ENTITY a "b">]>'


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused(read, encoding):
    text = document(head=ENTITY).decode().replace('"1.0"?', f'"1.0" encoding="{encoding}"?')
    with pytest.raises(WorkbenchError, match="it declares its own entities"):
        read(text.encode(encoding))


def test_a_bomb_of_instances_is_refused_at_once(read):
    double = "<node id='n{}'><instance_node url='#n{}'/><instance_node url='#n{}'/></node>"
    library = f"<node id='n0'>{GEOMETRY}</node>"
    library += "".join(double.format(i + 1, i, i) for i in range(40))
    with pytest.raises(WorkbenchError, match="it has more than 20000 nodes"):
        read(document("<node><instance_node url='#n40'/></node>", library=library))


def test_too_many_faces_of_all_instances_are_refused(read, monkeypatch):
    monkeypatch.setattr(collada, "MAX_MESH_FACES", 3)
    assert len(read(document(TRIANGLE * 3))) == 3
    with pytest.raises(WorkbenchError, match="it has more than 3 faces"):
        read(document(TRIANGLE * 4))


@pytest.mark.parametrize("data", [b"", b"PK\3\4", b"<COLLADA", b"no XML"])
def test_what_is_no_xml_is_refused(read, data):
    with pytest.raises(WorkbenchError, match="^not XML: "):
        read(data)


def test_a_document_without_a_scene_is_refused(read):
    data = document().replace(b'<scene><instance_visual_scene url="#sc"/></scene>', b"")
    with pytest.raises(WorkbenchError, match="it has no scene"):
        read(data)
