# ruff: noqa: E501
"""Broken jobs: each message has the file, the line, the table, the key, the value, and what is allowed."""

import json

import pytest

from tests.support.jobs import TRAY, write_tray
from weavesim import InputError
from weavesim.job.build import setup_of
from weavesim.job.overrides import overridden
from weavesim.job.read import read_job
from weavesim.job.schema import Job
from weavesim.job.tables import schema_of

# What is replaced in the tray, by what, and the message.
BROKEN = [
    ("[output]", '[process]\nsymmetry = ["x"]\n[output]', "[[ply]] ply: it goes from x = -100 to 100 mm, through the plane of symmetry x = 0"),
    ("[output]", "[fabric.mine]\nthickness = 1e-3\n[output]", "line 29, [fabric.mine]: no ply is of it; write fabric = 'mine'"),
    ('fabric = "glass', 'fabrik = "glass', "line 5, [[ply]] ply: fabrik = 'glass-polypropylene': unknown name; did you mean 'fabric'?"),
    ('fabric = "glass-polypropylene"', "", "[[ply]] ply: fabric: is required"),
    ('"glass-polypropylene"', '"glass-polypropilene"', "line 5, [[ply]] ply: fabric 'glass-polypropilene' is unknown"),
    ('"glass-polypropylene"', '"mine.toml"', "fabric = 'mine.toml': there is no such file in the folder of the job"),
    ('"glass-polypropylene"', '"../mine.toml"', "leads out of the folder of the file that refers to it"),
    ('"glass-polypropylene"', "5", "line 5, [[ply]] ply: fabric = 5: a text is needed"),
    ('["200 mm", "160 mm"]', '"200 mm"', "rectangle = 0.2: give a list"),
    ('["200 mm", "160 mm"]', '["200 mm", "-160 mm"]', "rectangle.1 = -0.16: a number above 0 is needed"),
    ('["200 mm", "160 mm"]', '["200 mm"]', "rectangle"),
    ('["200 mm", "160 mm"]', '["200 mm", "160 mm", "2 mm"]', "at most 2 values are allowed, here are 3"),
    ('offset_of = "die"', 'shape = "Sphere"', "shape = 'Sphere': a table of names and values is needed"),
    ('["200 mm", "160 mm"]', "[200, 160]", "the largest is 200; at most 20 m is allowed: write 0.2 for 200 mm"),
    ('rectangle = ["200 mm", "160 mm"]', "", "rectangle, disc, polygon or outline: one of them is needed, none is given"),
    ('rectangle = ["200 mm"', 'disc = "2 cm"\nrectangle = ["200 mm"', "one of them is needed, rectangle and disc are given"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 mmm"', "line 7, [[ply]] ply: mesh_size = '10 mmm': 'mmm' is no unit that is known"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 kg"', "mesh_size = '10 kg': 'kg' is no unit of it, write '5 mm' or a number in m"),
    ('mesh_size = "10 mm"', "mesh_size = 10", "mesh_size = 10: at most 0.5 m is allowed: write 0.01 for 10 mm"),
    ('mesh_size = "10 mm"', "mesh_size = true", "mesh_size = True: a number is needed, not true or false"),
    ('mesh_size = "10 mm"', 'mesh_size = "ten"', "mesh_size = 'ten': a number with its unit is needed, such as '5 mm'"),
    ('mesh_size = "10 mm"', "", "[[ply]] ply: mesh_size: is required"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 mm"\nmesh_along = "yarn"', "mesh_along = 'yarn': one of 'yarns' or 'outline' is needed"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 mm"\nlayer = "cut"', "layer: has no effect without a file as outline"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 mm"\nangle = "1 N"', "angle = '1 N': 'N' is no unit of it, write '45 deg'"),
    ('mesh_size = "10 mm"', 'mesh_size = "10 mm"\nmesh_size = "5 mm"', "no valid TOML"),
    ('mesh_size = "10 mm"', "mesh_size = 10 mm", "a number stands without its unit"),
    ('mesh_size = "10 mm"', "mesh_size = .01", "a number needs a digit before its point"),
    ('file = "die.stl"', 'file = "dye.stl"', "line 11, [[tool]] die: file = 'dye.stl': there is no such file"),
    ('file = "die.stl"', 'file = "/etc/passwd"', "leads out of the folder"),
    ('file = "die.stl"', 'file = "tray.toml"', "which is no format that is known"),
    ('unit = "mm"', "", "unit: is required with die.stl, whose format does not say it"),
    ('unit = "mm"', 'unit = "m"', "it is probably in millimetres and 1000 times too big. Give unit = \"mm\" for millimetres."),
    ('unit = "mm"', 'unit = "um"', "its unit seems too small. Give unit = \"m\" for metres, unit = \"mm\" for millimetres."),
    ('unit = "mm"', 'unit = "kg"', "unit = 'kg': a unit of length is needed, such as 'mm'"),
    ('faces = "up"', "", 'faces: is required with a file: "up" for a tool below the sheet'),
    ('faces = "up"', 'faces = "upp"', "line 13, [[tool]] die: faces = 'upp': one of 'up' or 'down' is needed"),
    ('faces = "up"', 'faces = "up"\nup = "z"', "up = 'z': one of '+x', '-x', '+y', '-y', '+z' or '-z' is needed"),
    ('faces = "up"', 'faces = "up"\nmass = "3 kg"', "mass: has no effect without a force; leave it out"),
    ('faces = "up"', 'faces = "up"\nfriction = "20 N"', "friction = '20 N': 'N' is no unit of it, write '0.2'"),
    ('faces = "up"', 'faces = "up"\nfriction = -0.1', "friction = -0.1: at least 0 is needed"),
    ('faces = "up"', 'faces = "up"\nmove = [0, 1]', "[[tool]] die: move"),
    ('name = "punch"', 'name = "die"', "line 16, [[tool]] die: name = 'die': another [[tool]] has it"),
    ('name = "punch"', 'name = ""', "a name is needed"),
    ('name = "punch"', "", "[[tool]]: name: is required"),
    ('offset_of = "die"', 'offset_of = "dye"', "offset_of = 'dye': there is no such [[tool]]; did you mean 'die'?"),
    ('offset_of = "die"', 'offset_of = "punch"', "offset_of = 'punch': there is no such [[tool]]"),
    ('offset_of = "die"', 'offset_of = "ring"', "offset_of = 'ring': that tool needs a file as its surface"),
    ('offset_of = "die"', 'offset_of = "die"\nfile = "die.stl"', "one of them is needed, file and offset_of are given"),
    ('gap = "1.2 mm"', "", "gap: is required with offset_of"),
    ('gap = "1.2 mm"', 'gap = "0 mm"', "gap = 0.0: a number above 0 is needed"),
    ('gap = "1.2 mm"', 'gap = "120 mm"', "at most 0.1 m is allowed"),
    ('start = "touching"', 'start = "touch"', "start = 'touch': one of 'drawn' or 'touching' is needed"),
    ('start = "touching"\nclearance = "1 mm"', "", 'stroke = "close": the tool starts 0 mm beyond where it is drawn'),
    ('stroke = "close"', 'stroke = "cloze"', "stroke = 'cloze': a number with its unit is needed, such as '5 mm'; or 'close'"),
    ('stroke = "close"', "stroke = 0", "stroke = 0: for a tool at rest leave it out"),
    ('stroke = "close"', 'stroke = "close"\nforce = "1 N"', "stroke, force, forces and gaps: a tool moves by one of them, several are given"),
    ('stroke = "close"', "", "speed: has no effect without a stroke; leave it out"),
    ('speed = "1 m/s"', "", "speed: is required with a stroke"),
    ('speed = "1 m/s"', 'speed = "1 m"', "speed = '1 m': 'm' is no unit of it, write '500 mm/s'"),
    ('speed = "1 m/s"', "speed = 1e9", "speed = 1000000000.0: at most 1e+04 m/s is allowed"),
    ('[[tool]]\nname = "ring"', '[tool.ring]\nname = "ring"', "[[tool]] punch: ring: unknown name"),
    ("[output]", "[ouput]", "line 29: ouput: unknown name; did you mean 'output'?"),
    ("[output]", "[[output]]", "[output]: a table is needed"),
    ("[output]", "[[stage]]\n[output]", "line 29, [[stage]]: name: is required"),
    ("[output]", '[scene]\nname = "double-dome"\n[output]', "[scene] brings its own; leave [ply] out, or [scene]"),
    ("[output]", "[tools]\n[output]", "line 29: tools: unknown name; write [[tool]]"),
    ("[output]", '[solver]\nprecision = "float16"\n[output]', "line 30, [solver]: precision = 'float16'"),
    ("[output]", "[solver]\nthreads = 0\n[output]", "threads = 0: at least 1 is needed"),
    ("[output]", '[process]\nsymmetry = ["z"]\n[output]', "[process]: symmetry.0 = 'z': one of 'x' or 'y' is needed"),
    ("[output]", '[process]\nduration = "2 m"\n[output]', "duration = '2 m': 'm' is no unit of it, write '2 ms'"),
    ("[output]", '[fabric.mine]\nbased_on = "nothing"\n[output]', None),
    ("frame_count = 10", "frame_count = 0", "frame_count = 0: at least 1 is needed"),
    ("frame_count = 10", "frames = 10", "line 30, [output]: frames = 10: unknown name"),
    ("frame_count = 10", 'write = ["movie"]', None),
    ('name = "tray"', 'name = "a/b"', "name = 'a/b': it becomes the name of files: without /"),
    ('name = "tray"', "name = 2020-01-01", "is a date or a time"),
    ('name = "tray"', "accept_unusual = 1", "accept_unusual = 1: true or false is needed"),
    (TRAY, "", "[[ply]]: at least one is needed, or a [scene]"),
    (TRAY, "[scene]\nname = \"double-dom\"\n", None),
    (TRAY, "{}", "it looks like JSON"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), BROKEN, ids=range(len(BROKEN)))
def test_a_broken_job_is_refused_with_its_place_and_what_is_allowed(tmp_path, old, new, message):
    assert old in TRAY
    path = write_tray(tmp_path, TRAY.replace(old, new, 1))
    if message is None:  # told when it is used, not when it is read
        read_job(path)
        return
    with pytest.raises(InputError) as error:
        setup_of(read_job(path))
    assert str(error.value).startswith(f"job {path}")
    assert message in str(error.value)


def test_the_tray_itself_is_not_broken(tmp_path):
    read_job(write_tray(tmp_path))


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("tools.rung.force=600", "no [[tool]] is named 'rung'; there are die, punch, ring; did you mean 'ring'?"),
        ("tools.ring.force", "give --set TABLE.NAME.KEY=VALUE"),
        ("tools.force=600", "there are several [[tool]]; name one of die, punch, ring"),
        ("tools.ring.force=600 kg", "--set tools.ring.force=600 kg, [[tool]] ring: force = '600 kg': 'kg' is no unit"),
        ("tools.ring.farce=600", "--set tools.ring.farce=600, [[tool]] ring: farce = 600: unknown name; did you mean"),
        ("processes.hold=1", "processes: unknown name; did you mean 'process'?"),
        ("name.hold=1", "name is a value, no table"),
        ("=5", "give --set"),
    ],
)
def test_a_broken_setting_is_refused_by_its_own_text(tmp_path, setting, message):
    with pytest.raises(InputError) as error:
        read_job(write_tray(tmp_path), [setting])
    assert message in str(error.value)


def test_settings_are_toml_or_text():
    values, _ = overridden({"tool": [{"name": "a"}]}, ["tools.a.move=[0, 0, 1]", "tools.a.friction=0.1", "name=x y"])
    assert values == {"tool": [{"name": "a", "move": [0, 0, 1], "friction": 0.1}], "name": "x y"}


def test_a_folder_that_the_user_names_may_be_read_from(tmp_path):
    (tmp_path / "job").mkdir()
    (tmp_path / "cad").mkdir()
    path = write_tray(tmp_path / "job")
    (tmp_path / "job" / "die.stl").rename(tmp_path / "cad" / "die.stl")
    with pytest.raises(InputError, match="or name its folder with --files-from"):
        setup_of(read_job(path))
    setup_of(read_job(path, files_from=[tmp_path / "cad"]))


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    (tmp_path / "job").mkdir()
    path = write_tray(tmp_path / "job")
    (tmp_path / "job" / "die.stl").rename(tmp_path / "die.stl")
    (tmp_path / "job" / "die.stl").symlink_to(tmp_path / "die.stl")
    with pytest.raises(InputError, match="leads out of the folder"):
        setup_of(read_job(path))


def test_a_job_may_be_json(tmp_path):
    import tomllib

    write_tray(tmp_path)
    path = tmp_path / "tray.json"
    path.write_text(json.dumps(tomllib.loads(TRAY)))
    assert setup_of(read_job(path)) == setup_of(read_job(tmp_path / "tray.toml"))


def test_a_fabric_may_stand_in_the_job(tmp_path):
    text = TRAY.replace('"glass-polypropylene"', '"mine"')
    table = '[fabric.mine]\nbased_on = "glass-polypropylene"\nthickness = 1.1e-3\n'
    setup = setup_of(read_job(write_tray(tmp_path, text + table)))
    assert setup.sheet.fabric.thickness == 1.1e-3
    with pytest.raises(InputError, match=r"job .*line 33, \[fabric.mine\]: thickness = 1.1: at most 0.05 m"):
        setup_of(read_job(write_tray(tmp_path, text + table.replace("e-3", ""))))


def test_the_schema_accepts_the_tray_and_refuses_a_slip():
    import tomllib

    from jsonschema import Draft202012Validator

    validator = Draft202012Validator(schema_of(Job))
    assert not list(validator.iter_errors(tomllib.loads(TRAY)))
    stage = '[[stage]]\nname = "hold"\nend = { rest = 1e-3 }\n[[stage.move]]\nname = "punch"\nfixed = true\n'
    assert not list(validator.iter_errors(tomllib.loads(TRAY + stage)))
    assert list(validator.iter_errors(tomllib.loads(TRAY + stage.replace("fixed", "fixt"))))
    assert list(validator.iter_errors(tomllib.loads(TRAY.replace("clearance", "clearence"))))


def test_every_key_has_a_description():
    from weavesim.job.schema import OutputTable, PlyTable, ProcessTable, SolverTable, ToolTable

    for table in (Job, PlyTable, ToolTable, ProcessTable, SolverTable, OutputTable):
        assert all(field.description for field in table.model_fields.values())


def test_the_example_of_the_reference_is_a_job(tmp_path):
    import re

    from scripts.doc_tables import text_of

    (example,) = re.findall(r"```toml\n(.*?)```", text_of("job.md"), flags=re.DOTALL)
    setup = setup_of(read_job(write_tray(tmp_path, example)))
    assert [tool.name for tool in setup.tools] == ["die", "punch", "ring"]
    assert setup.tools[1].motion.largest_force == 5000.0
    assert [gripper.name for gripper in setup.grippers] == ["corner_1", "corner_2"]
