"""Names stay names: no paths, no devices, no control characters."""

import pytest

from weavesim.errors import InputError
from weavesim.names import file_name


@pytest.mark.parametrize("name", ["double_dome", "Größe 3", "部品", "a.b", "a-b (2)", "x" * 100])
def test_names_of_files(name):
    assert file_name("name", name) == name


@pytest.mark.parametrize(
    "name",
    ["", " ", "../../evil", "..", ".", ".hidden", "a/b", "a\\b", "/etc/passwd", "a\nb", "a\0b", "a\tb", "a\x1bb",
     "con", "CON", "nul.txt", "Lpt1", "a:b", "x" * 101, "ä" * 51, "a.", "a ", "gr\udcf6\udcdfe", "a\u2028b",
     "a\u202eb"],
)  # fmt: skip
def test_what_is_no_name_of_a_file(name):
    with pytest.raises(InputError, match="^name = "):
        file_name("name", name)
