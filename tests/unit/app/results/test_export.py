"""``weavesim export``, in the words that a user sees."""

from functools import partial

import pytest


@pytest.fixture
def export_command(run_command):
    return partial(run_command, "export")


def test_files_are_named_and_assumptions_said(export_command, folder):
    code, out, _ = export_command(folder, "--to", "calculix, csv")
    assert code == 0
    assert f"wrote {folder / 'export' / 'small_calculix.inp'}" in out and "small.csv" in out
    assert "elastic constants of the layers: ASSUMED" in out
    assert (folder / "export" / "small.csv").stat().st_size


def test_a_whole_export_with_every_option(export_command, folder, tmp_path):
    import meshio

    meshio.write(tmp_path / "part.vtu", meshio.read(folder / "export" / "small_calculix.inp"))
    lamina = tmp_path / "lamina.toml"
    lamina.write_text(
        "modulus_along = 4e10\nmodulus_across = 9e9\npoisson_ratio = 0.3\nshear_modulus = 4e9\n"
        'shear_modulus_across = 3e9\ndensity = 1900\nsource = "our test 7"\n'
    )
    code, out, err = export_command(
        folder, "--to", "openradioss,abaqus", "--map", tmp_path / "part.vtu", "--within", 0.1, "--yarns", 1,
        "--lamina", lamina, "--reference", 0, 1, 0, "--out", tmp_path / "out", "--whole",
    )  # fmt: skip
    assert code == 0, err
    assert "mapped onto 24 elements" in out and "our test 7" in out
    assert "there are no mirrored copies to add" in out
    assert (tmp_path / "out" / "part_abaqus.inp").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "ansys"], "'ansys': choose from calculix"),
        (["--to", "csv", "--unit", "inch"], "choose from m, mm"),
        (["--to", "csv", "--map", "nothing.inp"], "mesh to map onto nothing.inp does not exist"),
        (["--to", "csv", "--map", "part.inp", "--within", "5"], "at most 0.1 m is allowed: write 0.005 for 5 mm"),
        (["--to", "csv", "--lamina", "nothing.toml"], "lamina file nothing.toml: cannot be read"),
    ],
)
def test_bad_input_is_told_before_anything_is_written(export_command, folder, tmp_path, options, message):
    code, _, err = export_command(folder, *options, "--out", tmp_path / "out")
    assert code == 2 and message in err
    assert not (tmp_path / "out").exists()


def test_a_run_that_should_not_be_used_says_so_when_it_is_exported(export_command, folder, tmp_path):
    code, out, _ = export_command(folder, "--to", "csv", "--out", tmp_path)
    assert code == 0 and "verdict" not in out
    summary = folder / "summary.json"
    assert not summary.exists()
    summary.write_text('{"verdict": "do not use"}')
    try:
        code, out, _ = export_command(folder, "--to", "csv", "--out", tmp_path)
    finally:
        summary.unlink()
    assert code == 0 and 'note: the verdict of this run is "do not use"' in out


def test_a_folder_that_is_no_run(export_command, tmp_path):
    code, _, err = export_command(tmp_path, "--to", "csv")
    assert code == 2 and "it has no results.h5" in err


def test_a_flat_pattern_with_its_waste(export_command, folder, tmp_path):
    pytest.importorskip("ezdxf")
    (tmp_path / "edge.csv").write_text("x,y\n5,5\n25,5\n25,15\n5,15\n")
    code, out, err = export_command(
        folder, "--flat", tmp_path / "flat.dxf", "--trim", tmp_path / "trim.dxf", "--part-edge", tmp_path / "edge.csv",
        "--edge-unit", "mm",
    )  # fmt: skip
    assert code == 0, err
    assert "blank 6.0 cm2, part 2.0 cm2, waste 4.0 cm2 (66.7%)" in out
    assert {path.name for path in tmp_path.iterdir()} == {"edge.csv", "flat.dxf", "trim.dxf", "flat.json"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "nothing to write; give formats (--to csv), or a drawing"),
        (["--flat", "a.dxf", "--part-edge", "no.csv"], "edge of the part no.csv"),
        (
            ["--flat", "a.dxf", "--part-edge", "no.csv", "--edge-unit", "kg"],
            "edge unit 'kg': a unit of length is needed",
        ),
        (["--flat", "a.dxf", "--edge-unit", "mm"], "they have an effect only with --part-edge"),
        (["--flat", "a.dxf", "--opening", "die"], "opening of die: there is no such tool"),
    ],
)
def test_a_flat_pattern_that_cannot_be_made_is_told(export_command, folder, options, message):
    code, _, err = export_command(folder, *options)
    assert code == 2 and message in err
