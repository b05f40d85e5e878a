"""How scripts report."""

import json

from scripts.shared.report import line_about, table, write_json


def test_a_table_has_a_cell_for_every_column():
    assert table(["a", "b"], [[1, 2.5], ["short"]]) == "| a | b |\n|---|---|\n| 1 | 2.5 |\n| short |  |"
    assert table(["a", "b"], [], right=True) == "| a | b |\n|---|---:|"


def test_numbers_are_written_whole(tmp_path):
    write_json(tmp_path / "rates.json", {"rows": [1]})
    assert json.loads((tmp_path / "rates.json").read_text()) == {"rows": [1]}
    assert [path.name for path in tmp_path.iterdir()] == ["rates.json"]


def test_the_machine_is_named_in_a_line():
    assert line_about({"cores": 2, "warp": "1.0"}) == "cores 2, warp 1.0"
