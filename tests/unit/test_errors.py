"""A logger says less for a while, and as much as before afterwards, whatever happens meanwhile."""

import logging

import pytest

from weavesim.errors import logged_from


def test_records_below_the_level_are_left_out(caplog):
    own, other = logging.getLogger("weavesim.run.guards.guard"), logging.getLogger("weavesim.tools")
    with caplog.at_level(logging.INFO, "weavesim"), logged_from(logging.ERROR, "weavesim.run.guards"):
        own.warning("hidden")
        own.error("told")
        other.info("told too")
    own.warning("afterwards")
    assert [record.message for record in caplog.records] == ["told", "told too", "afterwards"]


@pytest.mark.parametrize("level", [logging.NOTSET, logging.INFO])
def test_an_error_leaves_the_level_as_it_was(level):
    logger = logging.getLogger("weavesim.made")
    logger.setLevel(level)
    with pytest.raises(KeyError), logged_from(logging.CRITICAL, logger.name):
        assert logger.level == logging.CRITICAL
        raise KeyError
    assert logger.level == level
