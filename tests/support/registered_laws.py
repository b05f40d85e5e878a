"""All laws of the sheet, each with a fabric's values and its entry of the ledger: add one here and it is tested.

``tests/verification/element/test_energies.py`` compares the forces of each with its energy. Every registered
kind must be here: ``tests/unit/fabric/test_families.py``.
"""

from weavesim.fabric import (
    BendingCurve,
    IsotropicBending,
    LinearShear,
    MomentCurve,
    ShearFriction,
    Stabilisation,
    YarnBending,
)

CURVE = MomentCurve(angle=(0.0, 0.2, 0.5, 1.0), moment_values=(0.0, 3.0, 5.0, 20.0))
# from two degrees on, with its full slope reached inside the range of the test
LOCKING = CURVE.model_copy(update={"locking_angle": 0.035, "locking_width": 0.05, "locking_stiffness": 90.0})

# softens within the curvatures of the test
SOFTENING = BendingCurve(curvature=(0.0, 5.0, 15.0, 40.0), moment_values=(0.0, 0.04, 0.07, 0.1))
HELD = SOFTENING.model_copy(update={"friction_limit": 1e6, "friction_stiffness": 2e-3})

# What is added to a fabric that is a membrane only, and the entry of the ledger that must explain the change of forces.
TERMS = {
    "compression": ({"compressive_stiffness": 500.0}, "compression"),
    "linear shear": ({"shear": LinearShear(modulus=1.0e5)}, "shear"),
    "shear curve": ({"shear": CURVE}, "shear"),
    "locking": ({"shear": LOCKING}, "shear"),
    "in-plane bending": ({"in_plane_bending_stiffness": 5.0e-3}, "in_plane_bending"),
    "isotropic bending": ({"bending": IsotropicBending(modulus=2.0e7, poisson_ratio=0.3)}, "bending"),
    "yarn bending": ({"bending": YarnBending(warp=3e-3, weft=1e-3, twist=5e-4)}, "bending"),
    "bending curves": ({"bending": YarnBending(warp=SOFTENING, weft=2e-3, twist=5e-4)}, "bending"),
    "bending friction that holds": (
        {"bending": YarnBending(warp=HELD, weft=HELD.model_copy(update={"friction_stiffness": 4e-3}), twist=0.0)},
        "bending",
    ),
    "shear friction that holds": ({"shear_friction": ShearFriction(stiffness=60.0, limit=(1e6,))}, "shear"),
    "coupled yarn bending": ({"bending": YarnBending(warp=3e-3, weft=1e-3, twist=5e-4, coupling=1e-3)}, "bending"),
    "transverse shear": ({"transverse_shear_modulus": 1.0e5}, "transverse_shear"),
    "in-plane hourglass": (
        {"shear": LinearShear(modulus=1.0e5), "stabilisation": Stabilisation(in_plane=0.7, warping=0.0, director=0.0)},
        "hourglass",
    ),
    "warping hourglass": (
        {"transverse_shear_modulus": 1e5, "stabilisation": Stabilisation(in_plane=0.0, warping=0.7, director=0.0)},
        "hourglass",
    ),
    "director hourglass": (
        {
            "bending": IsotropicBending(modulus=2.0e7, poisson_ratio=0.3),
            "stabilisation": Stabilisation(in_plane=0.0, warping=0.0, director=0.7),
        },
        "hourglass",
    ),
}
