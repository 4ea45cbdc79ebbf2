"""Descriptions and worlds that try to do more than describe.

Each case is a file in a folder of its own, and the secret lies beside that folder. The last test
takes the interpreter of xacro away, so that only the kernel is left.
"""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.gains.gain_choice import flight_gains
from workbench.ipc.limited import run_limited
from workbench.ipc.sandbox import missing_protections
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import stored_files
from workbench.plant.loading import make_vehicle
from workbench.plant.worlds.reading import read_world

MISSING = missing_protections()
SECRET = "hunter2"
"""Stands in every file that may not be read."""
ROBOT = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'
LINK = f'<link name="{SECRET}"/>'
BY_CLASS = (
    "(lambda x: [c for c in x.__class__.__base__.__subclasses__() if c.__name__ == '_wrap_close']"
    "[0].__init__.__globals__['{0}']({1}))(1)"
)
MODULES = BY_CLASS.format("sys", "").replace("())(1)", ".modules)(1)")
FORK_EXEC = (
    ".fork_exec([b'/bin/touch', b'{mark}'], [b'/bin/touch'], False, (), None, None, "
    "-1, -1, -1, -1, -1, -1, -1, -1, False, False, -1, None, None, None, -1, None, True)"
)


def xacro(body: str) -> dict[str, str]:
    return {"a.xacro": ROBOT.format(body)}


def value(expression: str) -> dict[str, str]:
    text = expression.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    return xacro(f'<link name="${{{text}}}"/>')


def urdf(body: str) -> dict[str, str]:
    return {"a.urdf": ROBOT.format(body)}


def drawn(mesh: str) -> dict[str, str]:
    """A link that is drawn as a mesh."""
    shape = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    return {"a.urdf": f"{{quad:{shape}}}"}


def world(body: str) -> dict[str, str]:
    return {"w.yaml": body}


def external(root: str, path: str) -> str:
    return f'<!DOCTYPE x [<!ENTITY e SYSTEM "{path}">]>{root}'


OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n"
DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_images><image id="i"><init_from>{}</init_from></image></library_images></COLLADA>"""
GLTF = (
    '{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{}","byteLength":9}}],'
    '"images":[{{"uri":"{}"}}]}}'
)
ADD = (
    "directives:\n- add_model: {{name: c, file: {}}}\n- add_weld: {{parent: world, child: c::l}}\n"
)
PROGRAMS = {
    "xacro os.system": value(BY_CLASS.format("system", "'touch {mark}'")),
    "xacro os.popen": value(BY_CLASS.format("popen", "'touch {mark}'")),
    "xacro fork_exec": value(f"{MODULES}['_posixsubprocess']{FORK_EXEC}"),
    "xacro sqlite3": value(f"{MODULES}['sqlite3'].connect('{{mark}}')"),
    "xacro socket": value(f"{MODULES}['socket'].socket()"),
    "xacro import": value("__import__('os').system('touch {mark}')"),
    "xacro builtins": value("__builtins__['__import__']('os').system('touch {mark}')"),
    "xacro globals of a function": value("load_yaml.__globals__['os'].system('touch {mark}')"),
    "xacro frame": value("(x for x in [1]).gi_frame.f_back.f_globals['os'].system('touch {mark}')"),
    "xacro type": value("python.type('X', (), {})"),
    "xacro vars": value("python.vars(xacro)"),
    "xacro eval": xacro("<link name=\"$(eval __import__${'('}'os'))\"/>"),
    "xacro eval of a call": xacro("<link name=\"$(eval open${'('}'/etc/passwd'))\"/>"),
    "xacro property": xacro("<xacro:property name='p' value='${exec(1)}'/><link name='${p}'/>"),
    "xacro condition": xacro("<xacro:if value=\"${eval('1')}\"/>"),
    "xacro macro": xacro(
        "<xacro:macro name='m' params='p:=${().__class__}'><link name='${p}'/></xacro:macro>"
        "<xacro:m/>"
    ),
    "yaml of xacro": {
        **value("xacro.load_yaml('b.yaml')"),
        "b.yaml": "!!python/object/apply:os.system ['touch {mark}']",
    },
    "yaml of xacro, unit": {
        **value("xacro.load_yaml('b.yaml')"),
        "b.yaml": "!degrees '().__class__.__base__.__subclasses__()'",
    },
    "sidecar": {
        **urdf('<link name="l"/>'),
        "a.rotors.yaml": "rotors: !!python/object/apply:os.system ['touch {mark}']",
    },
    "world tag": world("title: !!python/object/apply:os.system ['touch {mark}']"),
    "world name": world("title: !!python/name:os.system"),
    "gains": {"g.yaml": "gains: !!python/object/apply:os.system ['touch {mark}']"},
}
"""Programs, sockets and files to write; `{mark}` is a file that would appear."""
READS = {
    "xacro include": xacro('<xacro:include filename="../secret.xacro"/>'),
    "xacro include, absolute": xacro('<xacro:include filename="{outside}/secret.xacro"/>'),
    "xacro include, optional": xacro('<xacro:include filename="../secret.xacro" optional="true"/>'),
    "xacro include, link": xacro('<xacro:include filename="link.xacro"/>'),
    "xacro include, pattern": xacro('<xacro:include filename="../*.xacro"/>'),
    "xacro include, folders": xacro('<xacro:include filename="../*/../secret.xacro"/>'),
    "xacro find": xacro('<xacro:include filename="$(find etc)/passwd"/>'),
    "xacro find, climbing": xacro('<xacro:include filename="$(find x)/../secret.xacro"/>'),
    "xacro find, hidden": xacro('<xacro:include filename="$(find .hidden)/secret.xacro"/>'),
    "xacro yaml": value("xacro.load_yaml('../secret.yaml')"),
    "xacro yaml, absolute": value("load_yaml('{outside}/secret.yaml')"),
    "xacro yaml, link": value("xacro.load_yaml('link.yaml')"),
    "xacro yaml, of the machine": value("xacro.load_yaml('/etc/hostname')"),
    "xacro yaml, of the process": value("xacro.load_yaml('/proc/self/environ')"),
    "xacro external entity": {"a.xacro": external(ROBOT.format("&e;"), "../secret.xacro")},
    "urdf external entity": {"a.urdf": external(ROBOT.format("&e;"), "file://{outside}/secret")},
    "urdf xinclude": urdf('<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="../s"/>'),
    "urdf mesh": drawn("../secret.obj"),
    "urdf mesh, absolute": drawn("file://{outside}/secret.obj"),
    "urdf mesh, link": drawn("link.obj"),
    "urdf mesh, package": drawn("package://x/../../secret.obj"),
    "world model": world(ADD.format("../secret.sdf")),
    "world model, absolute": world(ADD.format("file://{outside}/secret.sdf")),
    "world directives": world("directives:\n- add_directives: {file: ../secret.yaml}\n"),
    "world model's mesh": {
        **world(ADD.format("c.sdf")),
        "c.sdf": '<sdf version="1.9"><model name="c"><link name="l"><visual name="v"><geometry>'
        "<mesh><uri>../secret.obj</uri></mesh></geometry></visual></link></model></sdf>",
    },
    "obj material": {**drawn("a.obj"), "a.obj": f"mtllib ../../secret.mtl\n{OBJ}"},
    "obj picture": {
        **drawn("a.obj"),
        "a.obj": f"mtllib a.mtl\nusemtl m\n{OBJ}",
        "a.mtl": "newmtl m\nmap_Kd {outside}/../secret.png\n",
    },
    "dae picture": {**drawn("a.dae"), "a.dae": DAE.format("file://{outside}/../secret.png")},
    "dae external entity": {**drawn("a.dae"), "a.dae": external(DAE.format("&e;"), "../secret")},
    "gltf buffer": {**drawn("a.gltf"), "a.gltf": GLTF.format("../../secret.bin", "/etc/passwd")},
}
"""Files outside of the folder, in all ways of naming them."""
SECRETS = {
    "secret": SECRET,
    "secret.xacro": ROBOT.format(LINK),
    "secret.yaml": f"{SECRET}: 1\ndirectives: []\n",
    "secret.sdf": f'<sdf version="1.9"><model name="{SECRET}"><link name="l"/></model></sdf>',
    "secret.xml": f'<mujocoinclude><worldbody><body name="{SECRET}"><freejoint/></body>'
    "</worldbody></mujocoinclude>",
    "secret.obj": f"# {SECRET}\n{OBJ}",
    "secret.mtl": f"newmtl {SECRET}\n",
    "secret.bin": SECRET,
    "secret.png": SECRET,
    ".hidden/secret.xacro": ROBOT.format(LINK),
}


@pytest.fixture
def outcome(tmp_path, monkeypatch, quad):
    """Read the first file of a case; return all that it says and writes."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    outside = tmp_path / "stranger" / "outside"
    own = outside / "own"

    def put(path: Path, text: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        text = text.replace("{mark}", str(own / "mark")).replace("{outside}", str(outside))
        if text.startswith("{quad:"):
            text = quad.replace('<link name="base">', f'<link name="base">{text[6:-1]}')
        path.write_text(text)

    def read(files: dict[str, str]) -> str:
        for name, text in SECRETS.items():
            put(outside / name, text)
            put(tmp_path / "stranger" / name, text)
        for kind in ("xacro", "yaml", "sdf", "xml", "obj"):
            own.mkdir(exist_ok=True)
            (own / f"link.{kind}").symlink_to(outside / f"secret.{kind}")
        for name, text in files.items():
            put(own / name, text)
        before = snapshot()
        first = own / next(iter(files))
        said = _said(first)
        assert snapshot() == before
        return said.replace(str(tmp_path), "")

    def snapshot() -> dict[Path, bytes]:
        found = (path for path in (tmp_path / "stranger").rglob("*") if path.is_file())
        return {path: path.read_bytes() for path in found}

    return read


def _said(path: Path) -> str:
    try:
        if path.stem == "w":
            return str(read_world(path))
        if path.stem == "g":
            return str(flight_gains(None, str(path), controller=None))
        description = read_description(path)
        texts = [str(remark) for remark in description.remarks]
        texts += [data.decode("latin-1") for _, data in stored_files(description)]
        return "\n".join([*texts, repr(make_vehicle(description))])
    except WorkbenchError as error:
        return f"WorkbenchError: {error}"


@pytest.mark.parametrize("case", PROGRAMS)
def test_no_program_is_started_and_no_file_written(outcome, case):
    said = outcome(PROGRAMS[case])
    assert said.startswith("WorkbenchError: ")
    assert "\n" not in said
    assert "not permitted" not in said and "denied" not in said  # the kernel was not needed


@pytest.mark.parametrize("case", READS)
def test_no_file_outside_its_folder_is_read(outcome, case):
    assert_nothing_outside_is_read(outcome(READS[case]))


def assert_nothing_outside_is_read(said: str):
    assert SECRET not in said
    if said.startswith("WorkbenchError: "):
        assert "\n" not in said
        assert "denied" not in said  # the kernel was not needed
    else:  # it flies without the mesh or the picture, and a remark says so
        whys = ("outside of", "not found", "cannot be read", "no scene", "its own entities")
        assert any(why in said for why in whys)


HOLES = {
    "program": f"__import__('_posixsubprocess'){FORK_EXEC}",
    "file to write": "__import__('sqlite3').connect('{mark}').execute('create table t (a)')",
    "file to read": "open('{outside}/secret').read()",
    "socket": "__import__('socket').socket()",
}
"""Expressions, if Python evaluated them with all its names; tests/ipc/attempts.py has more."""


@pytest.mark.skipif(bool(MISSING), reason=f"not tested: the kernel lacks {MISSING}")
@pytest.mark.parametrize("case", HOLES)
def test_a_hole_in_the_interpreter_gains_nothing(tmp_path, monkeypatch, case):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    (tmp_path / "own").mkdir()
    (tmp_path / "secret").write_text(SECRET)
    path, mark = tmp_path / "own" / "a.xacro", tmp_path / "mark"
    text = HOLES[case].replace("{mark}", str(mark)).replace("{outside}", str(tmp_path))
    path.write_text(ROBOT.format(f'<link name="${{{text}}}"/>'))
    request = {"path": str(path), "args": {}, "roots": [str(tmp_path / "own")], "packages": {}}
    with pytest.raises(WorkbenchError) as caught:
        run_limited("holed_child", request, seconds=5.0, megabytes=400, reads=[tmp_path / "own"])
    assert SECRET not in str(caught.value) and "\n" not in str(caught.value)
    assert (tmp_path / "secret").is_file() and not mark.exists()


def test_there_are_enough_of_them():
    assert len(PROGRAMS) + len(READS) >= 40
