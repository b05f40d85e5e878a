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
    assert (tmp_path / "out" / "part_abaqus.inp").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--to", "ansys"], "'ansys': choose from calculix"),
        (["--to", "csv", "--unit", "inch"], "choose from m, mm"),
        (["--to", "csv", "--map", "nothing.inp"], "mesh to map onto nothing.inp does not exist"),
        (["--to", "csv", "--lamina", "nothing.toml"], "lamina file nothing.toml: cannot be read"),
    ],
)
def test_bad_input_is_told_before_anything_is_written(export_command, folder, tmp_path, options, message):
    code, _, err = export_command(folder, *options, "--out", tmp_path / "out")
    assert code == 2 and message in err
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_no_run(export_command, tmp_path):
    code, _, err = export_command(tmp_path, "--to", "csv")
    assert code == 2 and "it has no results.h5" in err
