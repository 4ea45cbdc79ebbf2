"""`workbench regress`."""

from xml.etree import ElementTree

import pytest

SPEC = """\
cases:
  - {name: hop, axis: z, amplitude: 0.5, duration: 0.5, limits: {peak: [0.2, 0.7]},
     baseline: {v_z: {absolute: 0.001}}}
  - {name: turn, axis: yaw, amplitude: 0.1, duration: 0.5, limits: {peak: {max: 0.2}}}
"""


@pytest.fixture
def spec(write):
    return write("one.workbench.yaml", SPEC)


def test_recorded_judged_changed(run, spec, tmp_path):
    new = run("regress", spec, "-j", 1)
    assert new.code == 1
    assert new.out.startswith("one.workbench.yaml: hop: v_z has no baseline yet")
    assert "1 of 2 cases failed" in new.out
    updated = run("regress", spec, "-j", 1, "--update")
    assert updated.code == 0, updated.out
    assert "one.baseline/hop.csv" in updated.err
    good = run("regress", spec, "-j", 1)
    assert (good.code, good.out) == (0, "all 2 cases passed\n")
    junit, html = tmp_path / "out" / "r.xml", tmp_path / "out" / "r.html"
    options = ("--set", "kp_velocity_z=3", "--junit", junit, "--html", html)
    bad = run("regress", spec, "-j", 1, *options)
    assert bad.code == 1
    assert "one.workbench.yaml: hop: v_z leaves its band" in bad.out
    assert "one.workbench.yaml: since the baseline: kp_velocity_z 4.4 -> 3" in bad.out
    top = ElementTree.parse(junit).getroot()
    assert (top.get("tests"), top.get("failures")) == ("2", "1")
    page = html.read_text()
    assert page.count("<svg") == 2
    assert page.index(">hop</a>") < page.index(">turn</a>")
    outside = page.replace("http://www.w3.org", "")
    assert "http://" not in outside.split("<body>")[1].replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    )
    assert "<script" not in page and "src=" not in page


@pytest.mark.slow
def test_processes_find_what_one_finds_and_json_tells_all(run, spec):
    run("regress", spec, "-j", 1, "--update")
    one, two = (run("regress", spec, "-j", n, "--json") for n in (1, 2))
    assert one.code == two.code == 0
    cases, same = one.json["cases"], two.json["cases"]
    for case in [*cases, *same]:
        case.pop("seconds")
    assert cases == same
    hop = cases[0]
    assert hop["case"] == "hop"
    assert hop["curves"][0]["band_use"] < 0.01
    assert hop["checks"][0]["min"] == 0.2
    assert cases[1]["checks"][0]["min"] is None  # open on that side


def test_one_case_is_no_crowd_and_a_difference_of_all_specs_stands_once(run, write):
    """As with a gain file that all specs fly with."""
    hop = "cases:\n  - {name: hop, axis: z, amplitude: 0.5, duration: 0.3,\n"
    specs = [
        write(f"{name}.workbench.yaml", hop + "     baseline: {v_z: {absolute: 0.001}}}\n")
        for name in ("one", "two")
    ]
    assert run("regress", specs[0], "-j", 1, "--update").out == "the case passed\n"
    assert run("regress", specs[1], "-j", 1, "--update").code == 0
    html = specs[0].parent / "r.html"
    said = run("regress", *specs, "-j", 1, "--set", "kp_velocity_z=3", "--html", html)
    *_, changed, last = said.out.splitlines()
    assert changed == "since the baseline: kp_velocity_z 4.4 -> 3"
    assert said.out.count("since the baseline") == 1
    assert last == "all 2 cases failed"
    assert html.read_text().count("since the baseline") == 1


def test_a_folder_means_its_specs(run, spec):
    assert run("regress", spec.parent, "-j", 1, "--update").code == 0


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--set", "kp_rol=1"], "did you mean 'kp_roll'?"),
        (["--vary", "mas=1"], "did you mean 'mass'?"),
        (["--vary", "mass=100"], "mass"),
        (["--update", "--set", "kp_roll=1"], "leave out --update"),
        (["-j", "0"], "--jobs is 0"),
        (["--physics-step", "1"], "physics_step"),
        (["gone.workbench.yaml"], "gone.workbench.yaml"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing(refused, spec, options, word, out):
    assert word in refused("regress", spec, "-j", 1, "--html", out / "r.html", *options)
    assert not out.parent.exists()
    assert not (spec.parent / "one.baseline").exists()


def test_a_broken_spec_is_named_with_its_line(refused, write):
    path = write("two.workbench.yaml", "cases:\n  - {name: a, axis: q, amplitude: 1}\n")
    assert f"{path}:2: unknown axis 'q'" in refused("regress", path)
