"""The audit of the dependencies: it passes here, and would not with a bad one."""

import tomllib
from email.message import Message

import pytest
from packaging.requirements import Requirement

from scripts.releasing.audit import READ, Found, bound_problems, installed, licence_of, licence_problem, requirements
from tests.support.paths import ROOT


@pytest.fixture(scope="module")
def wanted():
    return list(requirements(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]))


def test_every_requirement_has_a_least_version(wanted):
    assert len(wanted) > 20
    assert list(bound_problems(wanted)) == []


def test_what_is_installed_may_be_used(wanted):
    found, _, refused = installed(wanted)
    assert refused == []
    assert {"warp-lang", "numpy", "pydantic-core"} <= {one.name for one in found}
    assert [problem for one in found if (problem := licence_problem(one))] == []


def test_what_is_needed_to_run_asks_for_no_more_than_its_text(wanted):
    needed = [one for one in installed(wanted)[0] if not one.extra]
    assert not [one for one in needed if "GPL" in one.licence or "Proprietary" in one.licence]


@pytest.mark.parametrize("text", ["thing", "thing<2", "thing @ https://example.org/thing.whl"])
def test_a_requirement_without_a_bound_is_told(text):
    (problem,) = bound_problems([(Requirement(text), "test")])
    assert problem.startswith("thing (extra test): ")


@pytest.mark.parametrize(
    ("licence", "is_allowed"),
    [
        ("MIT", True), ("BSD-3-Clause AND Zlib", True), ("Mozilla Public License 2.0 (MPL 2.0)", True),
        ("GPL-3.0-or-later", False), ("GNU Lesser General Public License", False), ("AGPL", False),
        ("LicenseRef-Proprietary", False), ("", False), ("UNKNOWN", False), ("see the web page", False),
    ],
)  # fmt: skip
def test_licences_are_judged(licence, is_allowed):
    assert (licence_problem(Found("thing", "1", "", licence)) == "") is is_allowed
    assert licence_problem(Found(next(iter(READ)), "1", "", licence)) == ""


def test_a_licence_is_found_where_it_is_said():
    metadata = Message()
    metadata["License"] = "The MIT License (MIT)\n\nCopyright"
    assert licence_of(metadata) == "The MIT License (MIT)"
    metadata["Classifier"] = "License :: OSI Approved :: BSD License"
    assert licence_of(metadata) == "BSD License"
    metadata["License-Expression"] = "Apache-2.0"
    assert licence_of(metadata) == "Apache-2.0"


def test_an_old_version_is_refused():
    assert installed([(Requirement("numpy>=999"), "")])[2][0].endswith("is installed, >=999 is required")
