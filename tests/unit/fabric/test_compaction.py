"""Compaction that cannot be is refused."""

import pytest

from weavesim.errors import InputError
from weavesim.fabric.compaction import Compaction
from weavesim.fabric.presets import glass_polypropylene


@pytest.mark.parametrize(
    ("update", "message"),
    [
        ({"fibre_areal_density": 0.4}, "density together"),
        ({"fibre_areal_density": 0.9, "fibre_density": 2550.0}, "at most the areal density"),
        ({"fibre_areal_density": 0.7, "fibre_density": 255.0}, "more than round fibres can"),
        ({"thickening": 1.5}, "thickening"),
        ({"crossover_modulus": 0.0}, "crossover_modulus"),
    ],
)
def test_bad_compaction_is_refused(update, message):
    with pytest.raises(InputError, match=message):
        glass_polypropylene().model_copy(update={"compaction": Compaction(**update)})
