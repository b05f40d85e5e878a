"""What every run of a scene is held to, whatever its test looks at."""

from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from tests.support.summary_keys import keys_without_unit
from weavesim.output import files


@pytest.fixture(autouse=True)
def units_in_every_summary(monkeypatch) -> Iterator[None]:
    """Numbers that are written have their units in their names, also those that only a scene has."""
    found: list[str] = []
    text_of = files.summary_text

    def checked(summary: Mapping[str, Any]) -> str:
        found.extend(keys_without_unit(summary))
        return text_of(summary)

    monkeypatch.setattr(files, "summary_text", checked)
    yield
    assert not found
