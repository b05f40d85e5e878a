"""What surrounds the work of a command."""

import gc

import pytest

from weavesim.app.session import uncollected


def test_garbage_is_collected_again_afterwards_whatever_happens():
    assert gc.isenabled()
    with pytest.raises(ValueError, match="lost"), uncollected():
        assert not gc.isenabled()
        raise ValueError("lost")
    assert gc.isenabled()


def test_whoever_collects_nothing_keeps_it_so():
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
