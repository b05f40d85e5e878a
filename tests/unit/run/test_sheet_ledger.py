"""The deepest point of a sheet in the tools, at every place where its surface is judged."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven
from weavesim.run.sheet_ledger import JUDGED_PLACES
from weavesim.run.watch.tool_distance import ToolDistances
from weavesim.sheet.blank import Blank
from weavesim.sheet.samples import Surfaces
from weavesim.sheet.topology import at_corners
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

FABRIC = glass_polypropylene()
HALF = 0.5 * FABRIC.thickness


@pytest.mark.parametrize("samples", ["nodes", "surface"])
def test_the_deepest_point_is_that_of_all_places(samples):
    """Distances at nodes and samples are taken from the contact, the others measured: all as if measured at once."""
    tools = [
        Tool("lower", Sphere(0.05, origin=(0.01, 0.01, -0.05 - HALF)), friction=0.3),
        Tool("upper", Sphere(0.05, origin=(0.015, 0.01, 0.05 + HALF)), ForceDriven.constant(-20.0, 0.01), friction=0.2),
    ]
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=20.0)
    run = one_sheet_run(
        name="pressed", blank=blank, fabric=FABRIC, tools=tools, duration=1.0, precision="float64", threads=1,
        dynamics=Dynamics(contact_samples=samples), accept_unusual=True,
        initial_velocity=np.tile([0.4, 0.1, -0.1], (blank.node_count, 1)),
    )  # fmt: skip
    run.stepper.advance(10)
    frame = run.ledger.frame(1)
    (sheet,) = frame.sheets
    corners = sheet.position[blank.quads]
    at = [at_corners(values, blank.quads.T) for values in (sheet.position, sheet.director)]
    of_surface = Surfaces(JUDGED_PLACES)(*at)
    groups = [sheet.position, of_surface.reshape(-1, 3), corners.mean(axis=1)]
    distances = ToolDistances(run.model)
    found = [
        np.max([HALF - distances(tool, frame.place(tool), points)[0] for tool in range(2)], axis=0) for points in groups
    ]
    deepest = run.ledger.penetration(frame)
    assert deepest.at_nodes == found[0].max() and deepest.at_element_centres == found[2].max()
    assert deepest.at_surface == max(found[0].max(), found[1].max()) > 0.0
    at = np.concatenate(
        [blank.material_coordinates, np.tile(blank.material_coordinates[blank.quads].mean(axis=1), (9, 1))]
    )
    assert deepest.place == pytest.approx(at[int(np.argmax(np.concatenate(found[:2])))])
