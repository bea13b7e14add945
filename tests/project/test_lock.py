"""All that `make` installs is locked: every file by its hash, with the versions of constraints.txt."""

import re
import tomllib

import pytest

from tests.kits.paths import ROOT

LOCKS = ["run.lock", "test.lock", "bench.lock"]
PIN = re.compile(r"^([A-Za-z0-9_.-]+)==(\S+)", re.MULTILINE)


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(file: str) -> dict[str, str]:
    return {normal(name): version for name, version in PIN.findall((ROOT / file).read_text(encoding="utf-8"))}


def wanted(*extras: str) -> set[str]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lists = [project["dependencies"], *(project["optional-dependencies"][extra] for extra in extras)]
    return {normal(re.split(r"[\[<>=;~! ]", text)[0]) for one in lists for text in one}


VIEWERS = {"foxglove", "rerun"}
"""Extras that no test needs, of up to 170 MB."""


def test_the_locks_have_all_that_the_project_wants() -> None:
    tools = {"pip", "hatchling", "editables"}
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    assert wanted() | tools <= pins("run.lock").keys()
    locked = extras.keys() - VIEWERS
    assert wanted(*(locked - {"bench"})) | tools <= pins("test.lock").keys()
    assert wanted(*locked) | tools <= pins("bench.lock").keys()
    named = re.findall(r"--extra (\w+)", (ROOT / "Makefile").read_text(encoding="utf-8"))
    assert set(named) == locked


@pytest.mark.parametrize("file", LOCKS)
def test_every_line_of_a_lock_has_a_version_and_hashes_and_names_no_place(file: str) -> None:
    text = (ROOT / file).read_text(encoding="utf-8")
    assert "://" not in text
    entries = text.replace("\\\n", " ").strip().splitlines()
    assert all(re.match(r"[\w.-]+==\S+( ; [^-]+)?\s+(--hash=sha256:[0-9a-f]{64}\s*)+$", entry) for entry in entries)


def test_the_locks_versions_are_those_of_the_constraints() -> None:
    known = pins("constraints.txt")
    for file in LOCKS:
        other = {name: version for name, version in pins(file).items() if known.get(name, version) != version}
        assert not other, "make lock"
    assert pins("run.lock").items() <= pins("test.lock").items() <= pins("bench.lock").items()


def test_make_installs_by_hash() -> None:
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "--require-hashes" in text
    assert len(re.findall(r"^\t\$\(LOCKED\) \w+\.lock$", text, re.MULTILINE)) == len(LOCKS)
    installs = re.findall(r"^\t.*\$\(PIP\).*$", text, re.MULTILINE)
    assert installs == []  # what is installed goes through LOCKED, or is this project itself
    assert "--no-deps --no-build-isolation" in text
