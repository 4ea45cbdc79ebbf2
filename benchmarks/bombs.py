"""Descriptions, meshes, YAML files, worlds and logs that are small to send and large to read.

Each is read by a command of its own, which has to end with one sentence. Asked for: 5 s, and 512 MB
in all its processes together.

`python benchmarks/bombs.py [NAME ...]` reads those whose names contain one of the words.
"""

import gzip
import io
import json
import os
import resource
import struct
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

SECONDS, MEGABYTES = 5.0, 512.0
"""Asked for."""
LONGEST = 60.0
"""Time after which a command is killed [s]."""
PERIOD = 0.02
"""Period of the samples of memory [s]."""

Files = dict[str, str | bytes]
"""Contents by name; the command reads the first."""


@dataclass(frozen=True)
class Bomb:
    """Files that are small to send and large to read.

    Attributes:
        files: makes them.
        words: of the command before the name of the first file.
        quick: whether it takes milliseconds once the workbench is loaded.
    """

    files: Callable[[], Files]
    words: tuple[str, ...] = ("inspect",)
    quick: bool = False


INERTIAL = (
    '<inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
BOX = '<geometry><box size="1 1 1"/></geometry>'
SDF_BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
ENTITIES = (
    '<!DOCTYPE x [<!ENTITY a0 "aaaaaaaaaa">'
    + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 10))
    + "]>"
)
ALIASES = "a0: &a0 [x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)
)
MERGES = "a0: &a0 {x: 1}\n" + "".join(
    f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 9)}]}}\n" for i in range(1, 12)
)
FLY = ("fly", "hover", "--duration", "0.1", "--world")


def urdf(body: str) -> Files:
    """Return a URDF with one link, and more at its end."""
    return {"a.urdf": f'<robot name="a"><link name="l">{INERTIAL}</link>{body}</robot>'}


def in_link(body: str) -> Files:
    """Return a URDF with one link and what is in it."""
    return {"a.urdf": f'<robot name="a"><link name="l">{INERTIAL}{body}</link></robot>'}


def xacro(body: str) -> str:
    """Return the text of a xacro file."""
    return f'<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>'


def value(expression: str) -> Files:
    """Return a xacro file with an expression."""
    return {"a.xacro": xacro(f'<link name="${{{expression}}}"/>')}


def sdf(body: str) -> str:
    """Return the text of an SDF file with a model."""
    return f'<sdf version="1.9"><model name="m">{body}</model></sdf>'


def mesh(name: str, content: str | bytes, sides: Files | None = None) -> Files:
    """Return a link that is drawn and touches as a mesh."""
    shape = f'<geometry><mesh filename="{name}"/></geometry>'
    drawn = in_link(f"<visual>{shape}</visual><collision>{shape}</collision>")
    return {**drawn, name: content, **(sides or {})}


def chain(name: str, ending: str, inner: Callable[[str], str], last: str) -> Files:
    """Return 30 files, each of which includes the next one several times."""
    names = [f"{name}.{ending}", *(f"m{i}.{ending}" for i in range(1, 30))]
    files: Files = {own: inner(after) for own, after in zip(names, names[1:], strict=False)}
    return {**files, names[-1]: last}


def properties(first: str, later: str) -> Files:
    """Return properties, each made of several of the one before."""
    rows = [f"<xacro:property name='p0' value='{first}'/>"]
    rows += [
        f"<xacro:property name='p{i}' value='${{{later.format(f'p{i - 1}')}}}'/>"
        for i in range(1, 12)
    ]
    return {"a.xacro": xacro("".join(rows) + "<link name='${p11}'/>")}


def binary_stl(count: int, faces: bytes) -> bytes:
    """Return a binary STL that states a number of faces."""
    return bytes(80) + struct.pack("<I", count) + faces


def sphere_stl() -> bytes:
    """Return triangles whose corners are all on the convex hull."""
    corners = np.random.default_rng(0).normal(size=(300_000, 3))
    corners /= np.linalg.norm(corners, axis=1)[:, None]
    rows = np.zeros(100_000, [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows["v"] = corners.reshape(-1, 3, 3)
    return binary_stl(len(rows), rows.tobytes())


def glb(count: int, nodes: list[dict[str, object]], scene: list[int], *, stored: bool) -> bytes:
    """Return a binary glTF with one triangle, or with more vertices than it has bytes."""
    accessor = {"componentType": 5126, "count": count, "type": "VEC3"}
    head = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": scene}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{**accessor, "bufferView": 0} if stored else accessor],
        "buffers": [{"byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
    }
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def png(side: int) -> bytes:
    """Return a transparent picture."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(bytes(4 * side + 1)) for _ in range(side)) + packer.flush()
    head = struct.pack(">IIBBBBB", side, side, 8, 6, 0, 0, 0)
    chunks = chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + chunks


def textured(pictures: int, side: int) -> Files:
    """Return an OBJ whose materials have one picture each."""
    names = [f"m{i}" for i in range(pictures)]
    faces = "".join(f"usemtl {name}\nf 1/1 2/1 3/1\n" for name in names)
    materials = "".join(f"newmtl {name}\nmap_Kd p.png\n" for name in names)
    text = f"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{faces}"
    return mesh("m.obj", text, {"m.mtl": materials, "p.png": png(side)})


def collada(nodes: str, count: int = 9) -> str:
    """Return the text of a COLLADA document with one triangle."""
    numbers = "0 0 0 1 0 0 0 1 0"
    names = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    return (
        '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>'
        '<library_geometries><geometry id="g"><mesh><source id="p">'
        f'<float_array id="f" count="{count}">{numbers}</float_array><technique_common>'
        f'<accessor source="#f" count="3" stride="3">{names}</accessor></technique_common></source>'
        '<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">'
        '<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh>'
        f"</geometry></library_geometries>{nodes}"
        '<scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )


def doubled_nodes() -> str:
    """Return nodes, each with two instances of the one before."""
    nodes = ['<node id="n0"><instance_geometry url="#g"/></node>']
    twice = '<instance_node url="#{}"/>' * 2
    nodes += [f'<node id="n{i}">{twice.replace("{}", f"n{i - 1}")}</node>' for i in range(1, 40)]
    return (
        f"<library_nodes>{''.join(nodes)}</library_nodes><library_visual_scenes>"
        '<visual_scene id="s"><node><instance_node url="#n39"/></node></visual_scene>'
        "</library_visual_scenes>"
    )


def zipped() -> bytes:
    """Return an archive of 300 MB of zeros."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m.dae", bytes(300_000_000))
    return buffer.getvalue()


def tags(count: int, text: str) -> str:
    """Return a text repeated with numbers for {i}."""
    return "".join(text.replace("{i}", str(i)) for i in range(count))


FIXED = '<joint name="j{i}" type="fixed"><parent link="l"/><child link="l{i}"/></joint>'
STATIC = f'<collision name="c">{SDF_BOX}</collision>'
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
    "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"
)
TWICE = "<xacro:f n='${n-1}'/>" * 2
SIDECAR = {"a.urdf": f'<robot name="a"><link name="l">{INERTIAL}</link></robot>'}
YAML_OF_XACRO = value("xacro.load_yaml('b.yaml')")

BOMBS = {
    "xml entities, urdf": Bomb(lambda: {"a.urdf": f'{ENTITIES}<robot name="&a9;"/>'}, quick=True),
    "xml entities, sdf": Bomb(lambda: {"a.sdf": f"{ENTITIES}<sdf>&a9;</sdf>"}, quick=True),
    "xml entities, mjcf": Bomb(lambda: {"a.xml": f"{ENTITIES}<mujoco>&a9;</mujoco>"}, quick=True),
    "xml entities, xacro": Bomb(lambda: {"a.xacro": ENTITIES + xacro("&a9;")}, quick=True),
    "xml entities, dae": Bomb(lambda: mesh("m.dae", ENTITIES + collada("&a9;"))),
    "xml depth": Bomb(lambda: {"a.urdf": "<robot>" + "<a>" * 1_000_000}, quick=True),
    "xml elements": Bomb(lambda: urdf("<a/>" * 3_000_000)),
    "xml attributes": Bomb(lambda: {"a.urdf": "<robot " + tags(1_000_000, ' a{i}=""') + "/>"}),
    "links, urdf": Bomb(lambda: urdf(tags(20_000, f'<link name="l{{i}}"/>{FIXED}'))),
    "links, sdf": Bomb(lambda: {"a.sdf": sdf(tags(20_000, '<link name="l{i}"/>'))}),
    "links, mjcf": Bomb(
        lambda: {
            "a.xml": "<mujoco><worldbody><body><freejoint/>"
            + '<body><geom size="1"/></body>' * 20_000
            + "</body></worldbody></mujoco>"
        }
    ),
    "links, xacro": Bomb(
        lambda: {"a.xacro": xacro(tags(20_000, f'<link name="l${{{{i}}}}"/>{FIXED}'))}
    ),
    "frames, sdf": Bomb(
        lambda: {"a.sdf": sdf('<link name="l"/>' + tags(20_000, '<frame name="f{i}"/>'))}
    ),
    "joints": Bomb(lambda: urdf(f'<link name="l0"/>{tags(60_000, FIXED.replace("l{i}", "l0"))}')),
    "visuals": Bomb(lambda: in_link(f"<visual>{BOX}</visual>" * 20_000)),
    "collisions": Bomb(lambda: in_link(f"<collision>{BOX}</collision>" * 20_000)),
    "missing packages": Bomb(
        lambda: in_link(
            tags(999, '<visual><geometry><mesh filename="package://p{i}/m"/></geometry></visual>')
        )
    ),
    "xacro recursion": Bomb(
        lambda: {"a.xacro": xacro('<xacro:macro name="f"><xacro:f/></xacro:macro><xacro:f/>')}
    ),
    "xacro macros": Bomb(
        lambda: {
            "a.xacro": xacro(
                f"<xacro:macro name='f' params='n'><m/><xacro:if value='${{n>0}}'>{TWICE}"
                "</xacro:if></xacro:macro><xacro:f n='40'/>"
            )
        }
    ),
    "xacro blocks": Bomb(
        lambda: {
            "a.xacro": xacro(
                "<xacro:macro name='d' params='*b'><a>"
                + "<xacro:insert_block name='b'/>" * 2
                + "</a></xacro:macro>"
                + "<xacro:d>" * 30
                + "<m/>"
                + "</xacro:d>" * 30
            )
        }
    ),
    "xacro texts": Bomb(lambda: properties("aaaaaaaaaa", "{} * 10")),
    "xacro lists": Bomb(lambda: properties("${[1]}", "[{}] * 10")),
    "xacro repetition": Bomb(lambda: value("'a' * 10**10")),
    "xacro power": Bomb(lambda: value("9**9**9")),
    "xacro factorial": Bomb(lambda: value("factorial(10**8)")),
    "xacro comprehension": Bomb(lambda: value("[x for x in range(10**9)]")),
    "xacro sum": Bomb(lambda: value("python.sum(python.range(10**12))")),
    "xacro width": Bomb(lambda: value("'%10000000000d' % 1")),
    "xacro parentheses": Bomb(lambda: value("(" * 5000 + ")" * 5000)),
    "xacro signs": Bomb(lambda: value("-" * 100_000 + "1")),
    "xacro lambda": Bomb(lambda: value("(lambda f: f(f))(lambda f: f(f))")),
    "xacro includes": Bomb(
        lambda: chain(
            "a", "xacro", lambda name: xacro(f"<xacro:include filename='{name}'/>" * 2), xacro("")
        )
    ),
    "yaml aliases, xacro": Bomb(lambda: {**YAML_OF_XACRO, "b.yaml": ALIASES}),
    "yaml merges, xacro": Bomb(lambda: {**YAML_OF_XACRO, "b.yaml": MERGES}),
    "yaml rows, xacro": Bomb(lambda: {**YAML_OF_XACRO, "b.yaml": "- 1\n" * 3_000_000}),
    "yaml depth, xacro": Bomb(lambda: {**YAML_OF_XACRO, "b.yaml": "[" * 1_000_000}),
    "yaml aliases": Bomb(lambda: {**SIDECAR, "a.rotors.yaml": ALIASES}, quick=True),
    "yaml depth": Bomb(lambda: {**SIDECAR, "a.rotors.yaml": "rotors: " + "[" * 900_000}),
    "yaml rows": Bomb(lambda: {**SIDECAR, "a.rotors.yaml": f"rotors: [{'1,' * 450_000}]"}),
    "yaml digits": Bomb(lambda: {**SIDECAR, "a.rotors.yaml": "rotors: " + "9" * 900_000}),
    "yaml sexagesimal": Bomb(lambda: {**SIDECAR, "a.rotors.yaml": "rotors: 1" + ":59" * 300_000}),
    "yaml aliases, gains": Bomb(lambda: {"g.yaml": ALIASES}, ("hover", "--gains")),
    "yaml aliases, scenario": Bomb(lambda: {"s.yaml": ALIASES}, ("fly",)),
    "yaml aliases, world": Bomb(lambda: {"w.yaml": ALIASES}, FLY),
    "sdf includes": Bomb(
        lambda: chain(
            "a",
            "sdf",
            lambda name: sdf(tags(9, f"<include><name>n{{i}}</name><uri>{name}</uri></include>")),
            sdf('<link name="l"/>'),
        )
    ),
    "mjcf includes": Bomb(
        lambda: chain(
            "a",
            "xml",
            lambda name: "<mujoco>" + f'<include file="{name}"/>' * 9 + "</mujoco>",
            "<mujoco/>",
        )
    ),
    "world links": Bomb(
        lambda: {
            "w.sdf": sdf(
                "<static>true</static>" + tags(20_000, f'<link name="l{{i}}">{STATIC}</link>')
            )
        },
        FLY,
    ),
    "world models": Bomb(
        lambda: {
            "w.sdf": '<sdf version="1.9"><world name="w">'
            + tags(20_000, f'<model name="m{{i}}"><link name="l">{STATIC}</link></model>')
            + "</world></sdf>"
        },
        FLY,
    ),
    "world obstacles": Bomb(
        lambda: {
            "w.yaml": "obstacles:\n"
            + tags(15_000, "- {name: o{i}, shape: {box: [1, 1, 1]}, position: [{i}, 0, 0]}\n")
        },
        FLY,
    ),
    "obj faces": Bomb(
        lambda: mesh("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n" * 10_000_000)
    ),
    "obj polygon": Bomb(
        lambda: mesh("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + b" 1 2 3" * 300_000 + b"\n")
    ),
    "stl head": Bomb(lambda: mesh("m.stl", binary_stl(4_000_000_000, bytes(500)))),
    "stl noise": Bomb(lambda: mesh("m.stl", binary_stl(100_000, os.urandom(5_000_000)))),
    "stl hull": Bomb(lambda: mesh("m.stl", sphere_stl())),
    "ply faces": Bomb(lambda: mesh("m.ply", PLY.format(4_000_000_000))),
    "ply vertices": Bomb(lambda: mesh("m.ply", PLY.format(1))),
    "off head": Bomb(lambda: mesh("m.off", "OFF\n4000000000 1 0\n0 0 0\n")),
    "glb vertices": Bomb(
        lambda: mesh("m.glb", glb(4_000_000_000, [{"mesh": 0}], [0], stored=False))
    ),
    "glb nodes": Bomb(
        lambda: mesh(
            "m.glb",
            glb(
                3, [*({"children": [i + 1] * 2} for i in range(40)), {"mesh": 0}], [0], stored=True
            ),
        )
    ),
    "glb instances": Bomb(
        lambda: mesh("m.glb", glb(3, [{"mesh": 0}] * 100_000, list(range(100_000)), stored=True))
    ),
    "gltf depth": Bomb(lambda: mesh("m.gltf", "[" * 1_000_000)),
    "dae nodes": Bomb(lambda: mesh("m.dae", collada(doubled_nodes()))),
    "dae depth": Bomb(lambda: mesh("m.dae", "<COLLADA>" + "<node>" * 3_000_000)),
    "dae count": Bomb(lambda: mesh("m.dae", collada("", 4_000_000_000))),
    "picture": Bomb(lambda: textured(1, 12_000)),
    "pictures": Bomb(lambda: textured(40, 4_000)),
    "zip, zae": Bomb(lambda: mesh("m.zae", zipped())),
    "zip, dae": Bomb(lambda: mesh("m.dae", zipped())),
    "gz, stl": Bomb(lambda: mesh("m.stl", gzip.compress(bytes(300_000_000)))),
}
"""By name."""


def lay(bomb: Bomb, folder: Path) -> list[str]:
    """Write the files of a bomb to a folder, and return the words of its command."""
    files = bomb.files()
    for name, content in files.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    return [*bomb.words, str(folder / next(iter(files)))]


def memory(pid: int) -> float:
    """Return the memory of a process and its descendants [MB]."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:  # it has ended
        return 0.0
    lines = [line.split()[1] for line in status.splitlines() if line.startswith("VmRSS:")]
    return sum(map(float, lines)) / 1e3 + sum(memory(int(child)) for child in children)


def read(bomb: Bomb, cache: str) -> tuple[float, float, float, str, bool]:
    """Return wall and processor time [s], memory [MB], the last line, and whether it was well.

    Args:
        bomb: to read.
        cache: folder for the workbench's cache, with the compiled control law.
    """
    with tempfile.TemporaryDirectory() as folder:
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        process = subprocess.Popen(
            [sys.executable, "-m", "workbench", *lay(bomb, Path(folder))],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            cwd=folder,
            env=os.environ | {"XDG_CACHE_HOME": cache},
        )
        watchdog = threading.Timer(LONGEST, process.kill)
        watchdog.start()
        peak = 0.0
        while process.poll() is None:
            peak = max(peak, memory(process.pid))
            time.sleep(PERIOD)
        watchdog.cancel()
        assert process.stderr
        text = process.stderr.read().decode().replace(folder, "")
        wall, after = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    *_, said = text.strip().splitlines() or [f"nothing, code {process.returncode}"]
    refused = process.returncode == 2 and said.startswith("workbench: ")
    return wall, cpu, peak, said, process.returncode == 0 or refused


def all_bombs() -> dict[str, Bomb]:
    """Return these and the logs, by name."""
    from log_bombs import LOG_BOMBS  # made of the above

    return BOMBS | LOG_BOMBS


def main() -> int:
    """Read all bombs, or the named ones; return 1 if one takes more than is asked for."""
    words = sys.argv[1:]
    failed = []
    with tempfile.TemporaryDirectory() as cache:
        read(Bomb(lambda: {"w.yaml": "title: Nothing\n"}, FLY), cache)  # compiles the control law
        print(f"{'':22} {'wall s':>6} {'cpu s':>6} {'MB':>5}")
        for name, bomb in all_bombs().items():
            if words and not any(word in name for word in words):
                continue
            wall, cpu, peak, said, good = read(bomb, cache)
            if not good or wall > SECONDS or peak > MEGABYTES:
                failed.append(name)
            print(f"{name:22} {wall:6.1f} {cpu:6.1f} {peak:5.0f}  {said[:100]}", flush=True)
    print(f"\nmore than {SECONDS:g} s, {MEGABYTES:g} MB or a line: {', '.join(failed) or 'none'}")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main())
