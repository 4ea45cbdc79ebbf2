"""The files that a hosting service reads: they are YAML, and agree with pyproject.toml."""

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PYTHON = "Programming Language :: Python :: 3."


def read(name):
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


def test_the_workflow_has_a_job_for_each_python():
    job = read(".github/workflows/test.yml")["jobs"]["test"]
    promised = [line[len(PYTHON) - 2 :] for line in PROJECT["classifiers"] if PYTHON in line]
    assert job["strategy"]["matrix"]["python"] == promised
    assert job["steps"][-1]["run"] == ".ci/run ${{ matrix.python }}"
    caching = job["steps"][1]["with"]["cache-dependency-path"].split()
    assert [name for name in caching if not (ROOT / name).is_file()] == []


def test_the_citation_is_of_this_version():
    citation = read("CITATION.cff")
    assert citation["version"] == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]
    assert citation["authors"] == [{"name": "The Drake Drone Workbench authors"}]


def test_the_hooks_call_the_pinned_linter():
    (repository,) = read(".pre-commit-config.yaml")["repos"]
    assert repository["repo"] == "local"
    entries = [hook["entry"] for hook in repository["hooks"]]
    for entry, what in zip(entries, ("check", "format"), strict=True):
        assert entry.startswith(f".venv/bin/python -m ruff {what} ")


def test_the_forms_have_fields_of_their_own_names():
    for name in ("bug", "feature"):
        form = read(f".github/ISSUE_TEMPLATE/{name}.yml")
        assert {"name", "description", "body"} <= form.keys()
        names = [field["id"] for field in form["body"]]
        assert len(names) == len(set(names))


def test_the_changelog_has_this_version_and_a_place_for_the_next():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = [line.split()[1] for line in text.splitlines() if line.startswith("## ")]
    assert headings[:2] == ["[Unreleased]", PROJECT["version"]]


def test_a_person_starts_a_release_and_approves_it():
    workflow = read(".github/workflows/release.yml")
    assert workflow[True] == {"workflow_dispatch": None}  # YAML 1.1 reads `on` as true
    jobs = workflow["jobs"]
    trusted = [name for name, job in jobs.items() if "id-token" in job.get("permissions", {})]
    assert trusted == ["publish"] and jobs["publish"]["environment"] == "release"
    assert (jobs["publish"]["needs"], jobs["check"]["needs"]) == ("check", "build")
    pythons = jobs["check"]["strategy"]["matrix"]["python"]
    assert [f"{PYTHON}{python[2:]}" in PROJECT["classifiers"] for python in pythons] == [True] * 3


READY = {
    "pyproject.toml": '[project]\nversion = "1.2.0"\n',
    "CHANGELOG.md": "# Log\n\n## [Unreleased]\n\n## 1.2.0 - 2027-01-02\nNew.\n\n## 1.1.0 - 2\n",
    "CITATION.cff": "version: 1.2.0\ndate-released: 2027-01-02\n",
}


@pytest.mark.parametrize(
    ("name", "before", "after", "sentence"),
    [
        ("CHANGELOG.md", "[Unreleased]\n", "[Unreleased]\n- a line\n", "Unreleased is not empty"),
        ("CHANGELOG.md", "## 1.2.0 - 2027-01-02\nNew.\n", "", "newest section is `1.1.0 - 2`"),
        ("CHANGELOG.md", " - 2027-01-02", "", "name it `1.2.0 - DATE`"),
        ("CITATION.cff", "version: 1.2.0", "version: 1.1.0", "no line `version: 1.2.0`"),
        ("CITATION.cff", "-02", "-03", "no line `date-released: 2027-01-02`"),
        ("CITATION.cff", "", "", ""),
    ],
)
def test_a_release_that_is_not_ready_is_refused(tmp_path, name, before, after, sentence):
    for file, text in READY.items():
        (tmp_path / file).write_text(text.replace(before, after, 1) if file == name else text)
    command = [sys.executable, ROOT / "tools" / "release_notes.py", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True)
    if sentence:
        assert (done.returncode, done.stdout) == (2, "") and sentence in done.stderr
    else:
        assert (done.returncode, done.stdout) == (0, "New.\n"), done.stderr


def test_containers_have_what_they_run():
    """The programs of the app in a browser, and the files that the image copies."""
    dockerfile = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    script = (ROOT / "tools" / "app_in_browser.sh").read_text(encoding="utf-8")
    packages = ("tigervnc-standalone-server", "novnc", "openbox")
    for program, package in zip(("Xtigervnc", "websockify", "openbox"), packages, strict=True):
        assert re.search(rf"^{program}\b", script, re.MULTILINE) and f" {package}" in dockerfile
    for line in re.findall(r"^COPY (?!--from)(.*) \S+$", dockerfile, re.MULTILINE):
        assert [name for name in line.split() if not (ROOT / name).exists()] == []
    text = (ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8")
    container = json.loads(re.sub(r"^//.*$", "", text, flags=re.MULTILINE))
    assert container["postCreateCommand"] == "make test-setup"
