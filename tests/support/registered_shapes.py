"""All shapes of tools with a formula of their own: add one here and it is tested.

``tests/unit/tools/test_shapes.py`` compares the normals of each with differences of its distance, and its drawing with
its distance. Every registered kind must be here, but unions and meshes, and in ``tests/support/every_kind.py``.
"""

from weavesim.tools import Capsule, DomeCavity, DomeOpening, DomePunch, Plane, Sphere, Torus

PUNCH = DomePunch(0.06, 0.085)
OPENING = DomeOpening(0.0612, 0.085, 0.01)
SHAPES = [
    Plane(),
    Sphere(0.05),
    Capsule(0.03, 0.08),
    Torus(0.02, 0.07),
    PUNCH,
    DomePunch(0.05, 0.0),
    OPENING,
    DomeCavity(0.05, 0.0),
    DomeCavity(0.04, 0.08),
    DomeOpening(0.05, 0.0, 0.0),
    DomeOpening(0.04, 0.05, 0.0, display_size=(0.5, 0.3)),
]
