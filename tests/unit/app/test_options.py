"""Options common to all scenes."""

import pytest

from weavesim.app.options import RunOptions
from weavesim.checks import typed_as
from weavesim.errors import InputError
from weavesim.output.writer import known_writers


@pytest.mark.parametrize(
    ("given", "writers"),
    [
        ({}, ("film", "paraview", "results", "tables", "pictures", "report", "summary")),
        ({"write": "summary, film"}, ("film", "summary")),
        ({"without": "film,paraview"}, ("results", "tables", "pictures", "report", "summary")),
        ({"write": "film,tables", "without": "film"}, ("tables",)),
    ],
)
def test_results_are_chosen_by_name(given, writers):
    assert RunOptions(**given).writers == writers


@pytest.mark.parametrize("option", ["write", "without"])
def test_an_unknown_result_is_refused_with_the_known_ones(option):
    with pytest.raises(InputError, match=f"{option} = 'movie': .* choose from film, paraview"):
        RunOptions(**{option: "movie"})


def test_help_names_the_results():
    assert "film,paraview,results,tables,pictures,report,summary" in RunOptions.model_fields["write"].description


@pytest.mark.parametrize(("size", "message"), [(5.0, "write 0.005 for 5 mm"), (1e-5, "at least"), (-1.0, "mesh_size")])
def test_a_mesh_size_in_millimetres_is_refused(size, message):
    with pytest.raises(InputError, match=message):
        RunOptions(mesh_size=size)


def test_the_solver_takes_what_the_options_say():
    solver = RunOptions(threads=2, precision="float64", target_step=1e-6).solver(step_safety=0.5)
    assert (solver.threads, solver.precision, solver.target_step, solver.step_safety) == (2, "float64", 1e-6, 0.5)


def test_a_message_about_no_effect_has_only_the_names_of_options_as_typed():
    names = {"threads": "--threads", "device": "--device", "without": "--without", "out": "--out"}
    with typed_as(names), pytest.raises(InputError) as raised:
        RunOptions(threads=2, device="cuda:0")
    assert str(raised.value).endswith("--threads = 2: has no effect without --device = cpu; leave it out")


def test_fields_of_the_solver_need_the_frames_that_have_them():
    assert RunOptions(solver_fields=True).solver_fields and not RunOptions().solver_fields
    with pytest.raises(InputError, match="solver_fields: has no effect without the results paraview; leave it out"):
        RunOptions(solver_fields=True, without="paraview")


@pytest.mark.parametrize("name", ["", " "])
def test_a_folder_needs_a_name(name):
    with pytest.raises(InputError, match="out = .*a folder is needed"):
        RunOptions(out=name)


@pytest.mark.parametrize(
    "given",
    [{"write": ""}, {"write": " , "}, {"write": "film", "without": "film"}, {"without": ",".join(known_writers())}],
)
def test_a_run_that_would_leave_no_results_is_refused(given):
    with pytest.raises(InputError, match="no results would be written; choose from film"):
        RunOptions(**given)
