"""The table of what is known before a run: facts, and what to look at."""

import re

import numpy as np
import pytest

from tests.support.jobs import TRAY, changed, tray_surface, write_stl, write_tray
from tests.support.mesh_files import obj_text
from weavesim.job.advice.told import Row
from weavesim.job.build import setup_of
from weavesim.job.check import check_setup, table_of
from weavesim.job.read import read_job
from weavesim.sheet.blank import Blank

pytestmark = pytest.mark.usefixtures("tools_sampled_once")


def rows_of(folder, *changes):
    text = changed(TRAY, *changes)
    checked = check_setup(setup_of(read_job(write_tray(folder, text))))
    return checked, {(row.topic, row.what): row for row in checked.rows}


@pytest.fixture(scope="module")
def tray(tmp_path_factory):
    return rows_of(tmp_path_factory.mktemp("tray"))


def test_everything_that_is_asked_for_is_there(tray):
    checked, rows = tray
    assert {row.topic for row in checked.rows} >= {"plies", "tools", "gaps", "forces", "speeds", "cost"}
    assert rows["gaps", "die - punch"].judgement == "ok"
    assert rows["forces", "ring"].value == "in touch at the start"
    assert "suggested: 0.4 m/s" in rows["speeds", "punch"].advice
    assert "steps" in rows["cost", "time step"].value


def test_coarse_elements_and_a_fast_punch_are_to_be_looked_at(tray):
    checked, rows = tray
    assert rows["speeds", "punch"].judgement == "look"
    assert [row for row in checked.rows if row.what == "smallest radius"][0].judgement == "look"


def test_the_error_of_the_distance_is_told_for_every_mesh(tray):
    checked, _ = tray
    assert set(checked.errors) == {"die", "punch", "ring"}
    assert all(0.0 <= usual <= largest < 1e-3 for usual, largest in checked.errors.values())


def test_a_mesh_in_no_order_is_noted_with_its_remedy(tmp_path):
    flat = Blank.rectangle((0.0, 0.0), (0.35, 0.35), 0.005)
    random = np.random.default_rng(0)
    order = random.permutation(flat.node_count)
    quads = random.permutation(np.argsort(order)[flat.quads])
    (tmp_path / "blank.obj").write_text(obj_text(flat.node_position[order], quads))
    found = {}
    for numbering in ("kept", "neighbouring"):
        text = (
            f'[[ply]]\nfabric = "glass-polypropylene"\noutline = "blank.obj"\nunit = "m"\nnumbering = "{numbering}"\n'
            'mesh_size = "5 mm"\nheight = 0\n[process]\nduration = "1 ms"\n'
        )
        (tmp_path / "job.toml").write_text(text)
        checked = check_setup(setup_of(read_job(tmp_path / "job.toml")))
        found[numbering] = [row for row in checked.rows if row.what == "numbering"]
    (row,) = found["kept"]
    assert row.judgement == "note" and 'numbering = "neighbouring" mends that' in row.advice
    assert found["neighbouring"] == []


def test_a_run_without_end_is_to_be_looked_at(tmp_path):
    # a ply that lies on nothing: only the cost is asked for
    text = (
        '[[ply]]\nfabric = "glass-polypropylene"\nrectangle = ["40 mm", "40 mm"]\nmesh_size = "10 mm"\nheight = 0\n'
        '[process]\nduration = "1 ms"\n[output]\nframe_count = 1000000000\n'
    )
    (tmp_path / "job.toml").write_text(text)
    rows = check_setup(setup_of(read_job(tmp_path / "job.toml"))).rows
    (row,) = [row for row in rows if row.what == "bounds"]
    assert row.judgement == "look" and "of memory are free" in row.value


def test_a_gap_that_does_not_suit_the_stack_is_told(tmp_path):
    tight = rows_of(tmp_path, ('gap = "1.2 mm"', 'gap = "1 mm"'))[1]["gaps", "die - punch"]
    assert (tight.judgement, "too tight" in tight.advice) == ("look", True)
    loose = rows_of(tmp_path, ('gap = "1.2 mm"', 'gap = "3 mm"'))[1]["gaps", "die - punch"]
    assert (loose.judgement, "not pressed" in loose.advice) == ("note", True)


def test_a_holder_that_is_not_in_touch_is_told(tmp_path):
    changes = ('force = "600 N"', 'force = "600 N"\nclearance = "3 mm"')
    row = rows_of(tmp_path, changes)[1]["forces", "ring"]
    assert row.judgement == "look" and row.value.startswith("3 mm above the sheet")


def test_the_pressure_under_a_holder_is_judged_with_the_likely_slip(tmp_path, tray):
    row = tray[1]["forces", "pressure"]
    force, area, pressure = (float(part) for part in re.findall(r"[\d.]+(?= N| cm2| kPa)", row.value))
    # the ring covers the ply but for the opening: 160 mm x 120 mm and its entry radius
    assert (row.judgement, force) == ("ok", 600.0) and 90.0 < area < 160.0
    assert pressure == pytest.approx(1e-3 * force / (1e-4 * area), rel=2e-3)
    row = rows_of(tmp_path, ('force = "600 N"', 'force = "600 kN"'))[1]["forces", "pressure"]
    assert row.judgement == "look" and row.advice.endswith("to 2000 kPa; was 600 N meant, not kN?")
    assert float(row.value.split()[-2]) == pytest.approx(pressure, rel=2e-3) and row.value.endswith(" MPa")
    row = rows_of(tmp_path, ('force = "600 N"', "force = 0.5"))[1]["forces", "pressure"]
    assert row.judgement == "look" and row.advice.endswith("was 0.5 kN meant, not N?")


def test_a_force_of_a_stage_counts_under_the_holder(tmp_path):
    stage = '[[stage]]\nname = "close"\n[[stage.move]]\nname = "ring"\nforce = "600 kN"\n[output]'
    row = rows_of(tmp_path, ("[output]", stage.replace("[[stage.move]]", 'duration = "5 ms"\n[[stage.move]]')))[1]
    assert row["forces", "pressure"].judgement == "look"


def test_a_tool_that_meets_the_ply_in_a_point_has_no_pressure_yet(tmp_path):
    ball = 'shape = {kind = "Sphere", radius = "50 mm"}\nfaces = "down"\nstart = "touching"\n'
    text = TRAY[: TRAY.index('[[tool]]\nname = "punch"')] + f'[[tool]]\nname = "ball"\n{ball}force = "1 kN"\n'
    path = write_tray(tmp_path, text + '[process]\nduration = "1 ms"\n')
    rows = [row.what for row in check_setup(setup_of(read_job(path))).rows if row.topic == "forces"]
    assert rows == ["ball", "mass"]


def test_faults_of_a_mesh_are_rows_with_their_places(tmp_path):
    alone = TRAY[: TRAY.index('[[tool]]\nname = "punch"')] + '[process]\nduration = "1 ms"\n'
    path = write_tray(tmp_path, alone)
    vertices, faces = tray_surface()
    middle = vertices[faces].mean(axis=1)[:, :2]
    hole = np.arange(len(faces)) == 20  # a triangle of the bottom, which is flat
    turned = np.linalg.norm(middle - (-69.0, -49.0), axis=1) < 12.0
    faces[turned] = faces[turned][:, ::-1]
    write_stl(tmp_path / "die.stl", vertices, faces[~hole])
    checked = check_setup(setup_of(read_job(path)))
    rows = [row for row in checked.rows if row.topic == "tools"]
    (holes,) = [row for row in rows if row.what == "holes"]
    assert holes.judgement == "look" and holes.value.startswith("1 in the surface, ")
    x, y = (float(part) for part in holes.value.split("(")[1].split(",")[:2])
    gone = vertices[faces[hole][0]][:, :2]
    assert (gone.min(axis=0) < (x, y)).all() and ((x, y) < gone.max(axis=0)).all()
    (told,) = [row for row in rows if row.what == "repaired" and "the other way" in row.value]
    assert told.judgement == "note" and f"{turned.sum()} of {np.count_nonzero(~hole)} triangles" in told.value


def test_radii_errors_and_openings_are_told(tray):
    checked, rows = tray
    sharp = [row for row in checked.rows if row.what == "smallest radius"][0]
    assert "% of its surface has fewer than three, as about (" in sharp.value
    assert "with samples every" in rows["tools", "error of distance"].value
    # the ring has the opening of the die, which is no fault
    (opening,) = [row for row in checked.rows if row.what == "opening"]
    assert opening.judgement == "" and "mm across" in opening.value and not any(
        row.what == "holes" for row in checked.rows
    )  # fmt: skip


def test_the_table_is_folded_to_the_width():
    rows = [Row("topic", "what", "value " * 30, "look", "advice " * 10), Row("topic", "other", "5 mm")]
    lines = table_of(rows, 80).split("\n")
    assert lines[0] == "topic" and lines[1].startswith("  look  what   value")
    assert max(map(len, lines)) <= 80


def test_the_stages_are_told_with_what_acts_and_ends_them(tmp_path):
    from tests.unit.job.stages.test_build import STAGES

    checked = check_setup(setup_of(read_job(write_tray(tmp_path, TRAY + STAGES))))
    told = {row.what: row.value for row in checked.rows if row.topic == "stages"}
    assert list(told) == ["close", "hold", "open"]
    assert told["close"] == (
        "die, punch, ring act, corner_1, corner_2, corner_3, corner_4 pull; ends when punch is pushed with 5000 N, "
        "after 30 ms at the latest"
    )
    assert told["hold"].startswith("die, punch, ring act") and told["hold"].endswith(
        "punch stays, ring pushed with 100 N, 80 kPa on ply; takes 5 ms"
    )
    assert told["open"].startswith("die, punch act, punch moves by -20 mm; ends at rest")
    damping = {row.what: row for row in checked.rows if row.topic == "damping"}
    assert list(damping) == ["while tools move", "until open is at rest"]
    assert "critical for the slowest bending of the flat sheet" in damping["until open is at rest"].advice
    speeds = {row.what: row.value for row in checked.rows if row.topic == "speeds"}
    assert speeds["punch in open"] == "20 mm at 0.4 m/s"
