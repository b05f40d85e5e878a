"""Connected regions."""

import numpy as np

from weavesim.measures.defects.regions import regions
from weavesim.sheet.blank import Blank


def test_elements_that_share_a_node_are_one_region():
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.02), 0.01)
    # two elements across a corner, and one apart
    centre = np.round(blank.element_centres()[:, :2], 4).tolist()
    one, two, far = (centre.index(place) for place in ([0.005, 0.005], [0.015, 0.015], [0.045, 0.005]))
    chosen = np.zeros(blank.element_count, dtype=bool)
    chosen[[one, two, far]] = True
    found = regions(blank.quads, chosen)
    assert [region.tolist() for region in found] == [sorted([one, two]), [far]]


def test_nothing_chosen_is_no_region():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    assert regions(blank.quads, np.zeros(4, dtype=bool)) == []
