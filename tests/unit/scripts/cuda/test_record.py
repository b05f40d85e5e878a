"""Kernels build for CUDA devices, and need no more than their record says; this takes no GPU.

The record is ``record.json`` beside this file: python scripts/benchmark.py cuda --record.
"""

import json
from dataclasses import dataclass, replace

import pytest
import warp as wp

from scripts.benchmarks.cuda.record import ARCHITECTURES, RECORD, Entry, Record, content, excess, renewed
from scripts.benchmarks.cuda.resources import Resources, dump_program, resources, short_name
from scripts.benchmarks.cuda.users import kernels_by_user, kernels_of_scene
from weavesim.app.command_line import default_setups
from weavesim.device import initialise
from weavesim.kernel_cache import hashed_once

# Built in every run of the tests, whether they have changed or not: what most runs spend their time in.
ALWAYS = ("element_forces", "node_motion")

needs_dump = pytest.mark.skipif(dump_program() is None, reason="nvidia-cuda-cuobjdump is not installed")


@pytest.fixture(scope="module")
def record():
    return Record.read()


def faults(kernels, architecture, bound):
    """What exceeds its bound, a function of name and users, in words."""
    return [
        f"{short_name(kernel)} of {users[0]}, sm_{architecture}: {text}"
        for kernel, users in kernels.items()
        for text in excess(resources(kernel, architecture), bound(short_name(kernel), users))
    ]


@needs_dump
def test_no_kernel_that_has_changed_needs_more_than_its_record(record):
    """In single precision, one of each name; ``make verify`` builds all."""
    initialise()
    changed, names, missing = {}, set(), set()
    with hashed_once():
        for kernel, users in kernels_by_user("float32").items():
            name = short_name(kernel)
            if name in names or record.knows(content(kernel), wp.config.version):
                continue
            if record.bound(name, "float32", users, 90) is None:
                missing.add(name)
            else:
                names.add(name)
                changed[kernel] = users
    assert not missing, "not recorded: python scripts/benchmark.py cuda --record"
    assert not faults(changed, 90, lambda name, users: record.bound(name, "float32", users, 90))


@needs_dump
@pytest.mark.parametrize("name", ALWAYS)
def test_the_record_of_the_double_dome_is_what_the_compiler_gives(record, name):
    initialise()
    (setup,) = default_setups(["double-dome"], precision="float32")
    kernel = next(kernel for kernel in kernels_of_scene(setup) if short_name(kernel) == name)
    needs, bound = resources(kernel, 90), record.bound(name, "float32", ["double-dome"], 90)
    assert not excess(needs, bound)
    assert needs.instructions == pytest.approx(bound.instructions, rel=0.03)


@needs_dump
@pytest.mark.verification
@pytest.mark.parametrize("architecture", ARCHITECTURES)
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_every_kernel_needs_no_more_than_its_record(record, precision, architecture):
    initialise()
    kernels = kernels_by_user(precision)

    def bound(name, users):
        return record.bound(name, precision, users, architecture)

    missing = {short_name(kernel) for kernel, users in kernels.items() if bound(short_name(kernel), users) is None}
    assert not missing, "not recorded: python scripts/benchmark.py cuda --record"
    assert not faults(kernels, architecture, bound)


# --- the record itself ------------------------------------------------------------------------------------------------


def entry(kernel="nodes", users=("dome",), content="a", needs=(40, 0, 1000), **given):
    return Entry(kernel, "float32", users, content, dict.fromkeys(ARCHITECTURES, Resources(*needs)), **given)


def test_a_record_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "record.json"
    written = Record("1.0", [entry(), entry("forces", ("dome", "sphere"), "b", (128, 16, 3000))])
    written.write(path)
    read = Record.read(path)
    assert {each.kernel: each for each in read.entries} == {each.kernel: each for each in written.entries}
    assert len(path.read_text().splitlines()) == 2 + len(written.entries)


def test_a_kernel_that_doubles_is_told_though_it_is_small():
    bound = Record("1.0", [entry()]).bound("nodes", "float32", ["dome"], 90)
    assert excess(Resources(40, 0, 1030), bound) == []
    assert excess(Resources(80, 8, 1031), bound) == [
        "80 registers, recorded 40", "8 bytes of stack, recorded 0", "1031 instructions, recorded 1000",
    ]  # fmt: skip


def test_a_kernel_is_held_to_the_least_of_its_users_and_they_to_their_largest():
    record = Record(
        "1.0",
        [
            entry(users=("dome", "stack"), needs=(40, 0, 1000)),
            entry(users=("stack",), content="b", needs=(60, 0, 900)),
        ],
    )
    assert record.bound("nodes", "float32", ["stack"], 80) == Resources(60, 0, 1000)
    assert record.bound("nodes", "float32", ["stack", "dome"], 80) == Resources(40, 0, 1000)
    for unknown in (("forces", "float32"), ("nodes", "float64")):
        assert record.bound(*unknown, ["dome"], 80) is None
    assert record.bound("nodes", "float32", ["dome", "sphere"], 80) is None
    assert excess(Resources(255, 1000, 1), None) == []


@dataclass(frozen=True)
class Named:
    """In place of a kernel."""

    name: str
    content: str


def test_only_what_has_changed_is_built_anew(monkeypatch):
    module = "scripts.benchmarks.cuda.record"
    monkeypatch.setattr(f"{module}.content", lambda kernel: kernel.content)
    monkeypatch.setattr(f"{module}.short_name", lambda kernel: kernel.name)
    same, changed = Named("nodes", "a"), Named("forces", "new")
    before = Record("1.0", [entry(), entry("forces", content="old", needs=(100, 0, 2000))])
    kernels = {"float32": {same: ["dome"], changed: ["dome"]}}
    asked, stages = [], []

    def build(wanted):
        asked.extend((kernel.name, architecture) for kernel, architecture in wanted)
        return [Resources(101, 0, 2000)] * len(wanted)

    now, grown = renewed(before, kernels, "1.0", build, stages.append)
    assert asked == [("forces", 90), ("forces", 80)]
    assert [(each.kernel, each.content) for each in now.entries] == [("nodes", "a"), ("forces", "new")]
    assert grown == [f"forces, float32, sm_{sm}, dome: 101 registers, recorded 100" for sm in ARCHITECTURES]
    # who is interrupted after the first goes on with the second
    asked.clear()
    renewed(stages[0], kernels, "1.0", build, stages.append)
    assert asked == [("forces", 80)]
    asked.clear()
    renewed(replace(now, warp="0.9"), kernels, "1.0", build, stages.append)
    assert len(asked) == 4


def test_the_content_of_a_kernel_is_its_source_and_its_options_for_a_gpu():
    def made(factor):
        @wp.kernel(module="unique", enable_backward=False)
        def scaled(x: wp.array(dtype=float)):
            x[0] = wp.static(factor) * x[0]

        return scaled

    initialise()
    first, again, other = made(2.0), made(2.0), made(3.0)
    assert content(first) == content(again) != content(other)
    before, options = content(first), first.module.options
    options["cpu_compiler_flags"] = "-march=native"
    assert content(first) == before
    options["fast_math"] = True
    assert content(first) != before


def test_the_record_is_of_the_version_of_warp_that_is_installed():
    stored = json.loads(RECORD.read_text(encoding="utf-8"))
    assert stored["warp"] == wp.config.version, "another version of Warp: python scripts/benchmark.py cuda --record"
