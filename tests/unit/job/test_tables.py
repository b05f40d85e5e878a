"""Every unusual number of a job is asked about, whichever table it stands in, with its place and the likely slip."""

import json
import tomllib

import pytest

from tests.support.jobs import TRAY, changed, write_tray
from weavesim import InputError
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.schema import Job, PlyTable
from weavesim.job.tables import table_within, unusual_keys
from weavesim.ranges import quantity_of
from weavesim.study.factors import Factor
from weavesim.study.job_subject import JobSubject
from weavesim.study.plans.trials import Trial

MESH = 'mesh_size = "10 mm"'
# What is put in place of something in the tray, and the message: its place, the number, the slip.
UNUSUAL = [
    (MESH, f"{MESH}\nangle = 0.785", "line 8, [[ply]] ply: angle = 0.785 degrees: 0.785 is 44.98 degrees in radians"),
    (MESH, f"{MESH}\nturn = 1.5708", "line 8, [[ply]] ply: turn = 1.5708 degrees: 1.5708 is 90 degrees in radians"),
    (MESH, f"{MESH}\nheight = 50", "line 8, [[ply]] ply: height = 50 m: usual are 0 to 20 m; write 0.05 for 50 mm"),
    (MESH, f"{MESH}\nholes = [[[0, 0], [10, 0], [10, 10]], [[30, 0], [40, 0], [40, 10], [30, 10]]]",
     "line 8, [[ply]] ply: holes = up to 40 m"),
    ('speed = "1 m/s"', "speed = 400",
     "line 22, [[tool]] punch: speed = 400 m/s: usual are 1e-05 to 30 m/s; write 0.4"),
    ('speed = "1 m/s"', 'speed = "1 m/s"\ndelay = "1e4 s"', "line 23, [[tool]] punch: delay = 10000 s"),
    ('force = "600 N"', 'force = "600 N"\nmass = 1e5', "[[tool]] ring: mass = 100000 kg"),
    ('force = "600 N"', 'force = "600 N"\nfriction = 2', "[[tool]] ring: friction = 2: usual are 0 to 1.5"),
    ("[output]", "[[tool.segment]]\nnumber = 1\nforce = 1e9\n[output]",
     "[[tool]] ring, [[tool.segment]]: force = 1e+09 N"),
    ("[output]", '[[stage]]\nname = "a"\n[stage.friction]\nring = 3\n[output]', "[[stage]] a: friction = up to 3"),
    ("[output]", '[[stage]]\nname = "a"\n[[stage.move]]\nname = "punch"\nstroke = 3\nspeed = 1\n[output]',
     "[[stage]] a, [[stage.move]] punch: stroke = 3 m"),
    ("[output]", "[process]\ngravity = 9810\n[output]",
     "[process]: gravity = 9810 m/s^2: usual are 0 to 200 m/s^2; write 9.81"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), UNUSUAL)
def test_an_unusual_number_of_a_job_is_a_question(tmp_path, old, new, message):
    text = changed(TRAY.replace('force = "600 N"', 'force = "600 N"\nsegments = 4') if "segment" in new else TRAY,
                   (old, new))  # fmt: skip
    with pytest.raises(InputError) as caught:
        read_job(write_tray(tmp_path, text))
    assert "tray.toml, " in str(caught.value)
    assert message in str(caught.value)
    assert "write accept_unusual = true at the top of the job" in str(caught.value)
    read_job(write_tray(tmp_path, f"accept_unusual = true\n{text}"))


def test_all_are_asked_in_one_message_and_from_json_too(tmp_path):
    write_tray(tmp_path)
    values = tomllib.loads(changed(TRAY, ('speed = "1 m/s"', "speed = 400"), (MESH, f"{MESH}\nangle = 0.785")))
    path = tmp_path / "tray.json"
    path.write_text(json.dumps(values))
    with pytest.raises(InputError, match=r"(?s)2 values are unusual.*\[\[ply\]\] ply: angle.*punch: speed"):
        read_job(path)
    path.write_text(json.dumps({**values, "accept_unusual": True}))
    assert read_job(path).job.tool[1].speed == 400.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((MESH, f'{MESH}\nlayup = "0/0.785"'), "line 8, [[ply]] ply: a value is unusual"),
        (('force = "600 N"', 'force = "600 N"\nfriction = {kind = "Coulomb", coefficient = 3}'),
         "[[tool]] ring: a value is unusual"),
        (('ring_of = "die"', 'shape = {kind = "Sphere", radius = 8}\nfaces = "down"'),
         "[[tool]] ring: a value is unusual"),
    ],
)  # fmt: skip
def test_what_is_made_of_a_key_is_asked_there(tmp_path, change, message):
    with pytest.raises(InputError) as caught:
        setup_of(read_job(write_tray(tmp_path, changed(TRAY, change))))
    assert message in str(caught.value)
    assert "at the top of the job" in str(caught.value)


def test_a_value_that_a_study_varies_is_asked_too(tmp_path):
    subject, angle = JobSubject(write_tray(tmp_path)), Factor("angle", ("ply.angle",), high=0.785)
    subject.case([angle], Trial((0.0,)))
    with pytest.raises(InputError, match=r"--set ply.angle=0.785, .*: angle = 0.785 degrees: 0.785 is 44.98"):
        subject.case([angle], Trial((0.785,)))
    JobSubject(write_tray(tmp_path), ("accept_unusual=true",)).case([angle], Trial((0.785,)))


def _fields(table, path=()):
    """Every field with a quantity in a table and those within it: path of fields, tables on it, quantity."""
    for name, field in table.model_fields.items():
        inner = table_within(field)
        if inner is not None:
            for below, quantity in _fields(inner):
                yield (name, *below), quantity
        elif quantity_of(field) is not None:
            yield (name,), quantity_of(field)


FIELDS = [((*path,), quantity) for path, quantity in _fields(Job)]


def _nested(table, path, value):
    """A table whose field at the end of a path has a value; nothing else of it is checked."""
    name, *rest = path
    field = table.model_fields[name]
    empty = {key: None for key, each in table.model_fields.items() if each.is_required()}
    inner = table_within(field)
    if inner is not None:
        made = _nested(inner, rest, value)
        value = (made,) if "tuple" in str(field.annotation) else made
    return table.model_construct(**{**empty, name: value})


def test_the_tables_have_their_numbers():
    paths = {path for path, _ in FIELDS}
    assert {("ply", "angle"), ("tool", "segment", "force"), ("tool", "rotation", "angle"), ("stage", "end", "rest"),
            ("interface", "pair", "friction"), ("solver", "time_step"), ("gripper", "path")} <= paths  # fmt: skip
    assert len(paths) > 100


@pytest.mark.parametrize(("path", "quantity"), FIELDS, ids=[".".join(path) for path, _ in FIELDS])
def test_every_number_of_every_table_is_asked(path, quantity):
    high = quantity.row.plausible[1]
    for value in (1.7 * high, ((0.0, 1.7 * high), (0.0, 0.0, 0.0))):
        ((keys, sentence),) = unusual_keys(_nested(Job, path, value))
        assert tuple(key for key in keys if key != "0") == path
        assert sentence.startswith(f"{path[-1]} = ")
    assert not list(unusual_keys(_nested(Job, path, high)))


def test_what_is_left_out_is_usual():
    assert not list(unusual_keys(Job(ply=(PlyTable(fabric="mine", disc=0.2, mesh_size=0.01),))))
