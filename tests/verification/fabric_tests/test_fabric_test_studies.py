"""Picture frame, bias extension and cantilever at three mesh sizes, against kinematics and closed forms."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from weavesim.fabric.bending import YarnBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.closed_forms import heavy_elastica
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import ShearFriction
from weavesim.run.simulation import Simulation
from weavesim.scenes import bias_extension, cantilever, picture_frame
from weavesim.scenes.bias_extension import BiasExtensionParameters
from weavesim.scenes.cantilever import CantileverParameters
from weavesim.scenes.picture_frame import PictureFrameParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytestmark = pytest.mark.verification

SHEAR_MODULUS = 0.1e6
SPACING = 0.005


def stiff_straight_yarns(law: str, stiffness: float) -> Fabric:
    """The glass fabric's shear law (or the linear one) with straight yarns, and yarns free to bend in the plane."""
    fabric = glass_polypropylene()
    if law == "linear":
        fabric = fabric.with_linear_shear(SHEAR_MODULUS)
    else:
        fabric = fabric.model_copy(update={"shear": fabric.shear.model_copy(update={"locking_stiffness": 0.0})})
    # as stiff in compression as in tension, with one equilibrium
    bending = 1.001 * stiffness * SPACING * (0.5 * SPACING) ** 2 / 3.0
    cell = PlainWeave.straight(stiffness_per_width=stiffness, spacing=SPACING, bending=bending)
    return fabric.model_copy(
        update={"unit_cell": cell, "in_plane_bending_stiffness": 0.0, "compressive_stiffness": 0.0}
    )


def frame_test(law: str, **given) -> tuple[dict, dict[str, np.ndarray], dict[str, float]]:
    """Findings, columns and final energies of a picture-frame test without damping."""
    parameters = PictureFrameParameters(
        precision="float64", damping=0.0, yarn_tension=10.0, threads=1, frame_count=80, **given
    )
    fabric = stiff_straight_yarns(law, 2.0e5)
    simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
    curves = picture_frame.record(parameters, fabric)
    simulation.run([curves])
    return picture_frame.findings(curves), curves.columns, simulation.frame.energies


@pytest.mark.parametrize("law", ["linear", "curve"])
def test_picture_frame(law, manual):
    """Even shear is a state of every mesh, so the mesh does not matter; what is left is inertia, as speed squared."""
    names = {"linear": "the linear law of equation (4)", "curve": "the glass/polypropylene curve"}
    case = manual(
        "Fabric tests", f"Picture frame, {law} law",
        known=f"Frame of side $L$, yarns along its sides, {names[law]}: $\\gamma=\\pi/2-2\\arccos(1/\\sqrt2+d/2L)$ and "
        "$F\\,\\dot d=A\\,m(\\gamma)\\,\\dot\\gamma$. 0.2 m, 40 degrees, yarn tension 10 N/m, no damping.",
    )  # fmt: skip
    rows = []
    for size in (0.05, 0.025, 0.0125):
        found, c, _ = frame_test(law, mesh_size=size, speed=0.5)
        steady = (c["frame_angle_deg"] > 5.0) & (c["frame_angle_deg"] < 32.0)
        expected = np.maximum(c["closed_form_force_n"], 1e-6)
        deviation = np.abs(c["force_n"] / expected - 1.0)
        rows.append([
            1e3 * size, found["largest_angle_error_deg"], np.ptp([c["min_shear_angle_deg"], c["max_shear_angle_deg"]],
            axis=0).max(), 100.0 * deviation[steady].max(), 100.0 * deviation[-1],
        ])  # fmt: skip
        assert found["largest_angle_error_deg"] < 1e-6
        assert deviation[steady].max() < 0.02
        assert deviation[-1] < 5e-3
    case.table(
        ["element size [mm]", "largest error of the mean angle [deg]", "largest spread of the angle [deg]",
         "largest deviation of the force, 5 to 32 degrees [%]", "deviation at 40 degrees [%]"], rows,
    )  # fmt: skip
    case.text(
        "The uniform deformation is exact on every mesh. The deviation of the force is the inertia of the sheet: "
        "its kinetic energy $\\rho L^2\\dot d^2/48\\sin^2\\theta$, $\\theta$ half the angle at the pulled hinges, "
        "requires $\\rho L\\dot d^2\\cos\\theta/48\\sin^4\\theta$, which is proportional to the square of the speed. "
        "Means from 10 to 30 degrees on the finest mesh (with few elements, lumped masses have too much rotary "
        "inertia):"
    )
    rows = []
    for speed in (2.0, 1.0, 0.5):
        _, c, _ = frame_test(law, mesh_size=0.0125, speed=speed)
        half = np.radians(0.5 * (90.0 - c["frame_angle_deg"]))
        steady = (c["frame_angle_deg"] > 10.0) & (c["frame_angle_deg"] < 30.0)
        inertia = 0.743 * 0.2 * speed**2 * np.cos(half) / (48.0 * np.sin(half) ** 4)
        excess = (c["force_n"] - c["closed_form_force_n"])[steady].mean()
        rows.append([speed, inertia[steady].mean(), excess, excess / c["closed_form_force_n"][steady].mean()])
    case.table(["speed [m/s]", "force of inertia [N]", "excess of the force [N]", "over the closed form"], rows)
    for speed, expected, excess, _ in rows[:2]:
        assert excess == pytest.approx(expected, rel=0.1), speed


def rubbing_frame_test(
    tension: float, mesh_size: float, *, precision: str = "float64", damping: float = 10.0
) -> tuple[dict, dict[str, np.ndarray], dict[str, float]]:
    """Findings, columns, and what the ledger booked over the cycle, of the glass fabric with rubbing crossovers."""
    # friction 0.3 on a round patch of radius 1.3 mm, and 2 N/m that no tension needs
    friction = ShearFriction(stiffness=500.0, limit=(2.0,), crossover_friction_length=2.6e-4)
    fabric = glass_polypropylene().model_copy(update={"shear_friction": friction})
    parameters = PictureFrameParameters(
        yarn_tension=tension, mesh_size=mesh_size, speed=0.5, cycle=True, frame_count=200, threads=1,
        precision=precision, damping=damping,
    )  # fmt: skip
    simulation = Simulation(picture_frame.picture_frame(parameters, fabric))
    curves = picture_frame.record(parameters, fabric)
    simulation.run([curves])
    history, columns = simulation.history, curves.columns
    start = int(np.flatnonzero(columns["time_s"] <= picture_frame.TENSION_TIME)[-1])
    booked = {
        name: history[-1][name] - history[start][name]
        for name in ("shear_friction_loss", "damping_loss", "internal", "kinetic")
    }
    return picture_frame.findings(curves), columns, booked


def test_picture_frame_under_yarn_tension(manual):
    """Loading and unloading: force against the closed form at the crossovers' pressure, loop against what is booked."""
    case = manual(
        "Fabric tests", "Picture frame under yarn tension",
        known="Glass/polypropylene with friction of the crossovers, $m_f\\le2$ N/m $+\\,\\ell_cp_c$, $\\ell_c=0.26$ "
        "mm: $F\\,\\dot d=A\\,(m+m_f)\\,\\dot\\gamma$ along the frame's own angles, $m_f$ integrated on the host at "
        "the pressure $p_c$ of the unit cells. The area of the loop is the loss in the ledger. 0.2 m, 40 degrees "
        "and back, 0.5 m/s.",
    )  # fmt: skip
    loops, rows = {}, []
    for tension in (100.0, 400.0, 1000.0):
        found, c, booked = rubbing_frame_test(tension, 0.05)
        loops[tension] = c
        way = 1e-3 * np.diff(c["displacement_mm"])
        expected = c["closed_form_force_n"]
        known_loop = 0.5 * float((expected[1:] + expected[:-1]) @ way)
        loop, used = found["work_of_a_cycle_j"], sum(booked.values())
        rows.append([
            tension, found["closed_form_peak_force_n"], found["peak_force_n"], known_loop, loop, used,
            booked["shear_friction_loss"],
        ])  # fmt: skip
        assert found["peak_force_n"] == pytest.approx(found["closed_form_peak_force_n"], rel=0.02)
        assert np.abs(c["force_n"] - expected).mean() < 0.02 * expected.max()
        assert loop == pytest.approx(known_loop, rel=0.02)
        assert loop == pytest.approx(used, rel=0.02)
        assert booked["shear_friction_loss"] > 0.9 * loop
    case.table(
        ["yarn tension [N/m]", "known force at 40° [N]", "weavesim [N]", "known loop [J]", "loop of the force [J]",
         "ledger, in total [J]", "of which friction loss [J]"], rows,
    )  # fmt: skip
    peaks, areas = np.array(rows)[:, 2], np.array(rows)[:, 4]
    assert np.all(np.diff(peaks) > 0.0) and areas[-1] > 2.0 * areas[0]
    case.figure(_loops(loops))
    rows = []
    for size in (0.05, 0.025, 0.0125):
        found, _, booked = rubbing_frame_test(400.0, size)
        rows.append([1e3 * size, found["peak_force_n"], found["work_of_a_cycle_j"], booked["shear_friction_loss"]])
    case.text("Uniform shear is an equilibrium of every mesh, so the mesh has no influence; at 400 N/m:")
    case.table(["element size [mm]", "force at 40° [N]", "loop of the force [J]", "friction loss [J]"], rows)
    spread = np.ptp(np.array(rows)[:, 1:], axis=0) / np.array(rows)[0, 1:]
    assert spread.max() < 0.01
    rows = []
    for precision, damping in (("double", 10.0), ("single", 10.0), ("single", 50.0)):
        _, c, booked = rubbing_frame_test(400.0, 0.05, precision={"double": "float64"}.get(precision, "float32"),
                                          damping=damping)  # fmt: skip
        excess = c["force_n"] - c["closed_form_force_n"]
        rows.append([precision, damping, excess[101:].std(), booked["shear_friction_loss"]])
    case.text(
        "A limit that grows with the pressure derives from no potential, so in-plane vibrations of the tension can "
        "draw energy from the slip: once started, they grow during unloading, in either precision. At 10/s rounding "
        "in single precision is enough to start them; the tension then flutters and the loop is too small, although "
        "the energy balance still closes. A damping of 50/s suppresses them:"
    )
    case.table(
        ["precision", "damping rate [1/s]", "scatter of the force during unloading [N]", "friction loss [J]"], rows
    )
    assert rows[2][2] < 0.01 * peaks[1]
    assert rows[2][3] == pytest.approx(rows[0][3], rel=0.01)


def _loops(loops: dict[float, dict[str, np.ndarray]]) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 3.2))
    axes = figure.add_subplot()
    for tension, c in loops.items():
        (line,) = axes.plot(c["frame_angle_deg"], c["force_n"], lw=1.0, label=f"{tension:g} N/m")
        axes.plot(c["frame_angle_deg"], c["closed_form_force_n"], lw=3.5, alpha=0.3, color=line.get_color())
    axes.plot([], [], "k-", lw=3.5, alpha=0.3, label="closed form")
    axes.set_xlabel("angle of the frame [°]")
    axes.set_ylabel("force [N]")
    axes.legend(fontsize=7)
    axes.grid(lw=0.3)
    return figure


@pytest.mark.parametrize("law", ["linear", "curve"])
def test_bias_extension(law, manual):
    case = manual(
        "Fabric tests", f"Bias extension, {law} law",
        known="0.2 x 0.1 m, yarns at 45 degrees to the pull and to the elements, nearly inextensible "
        "($C=10^6$ N/m): zones A, B, C at 0, $\\gamma/2$, $\\gamma=\\pi/2-2\\arccos((D+d)/\\sqrt2D)$, $D=L-W$, and "
        "$F\\dot d=A_Cm(\\gamma)\\dot\\gamma+A_Bm(\\gamma/2)\\dot\\gamma/2$. No bending of the yarns in the plane.",
    )  # fmt: skip
    sizes = (0.0125, 0.00625, 0.1 / 24)
    results = {20.0: [], 39.0: []}
    for size in sizes:
        parameters = BiasExtensionParameters(mesh_size=size, threads=1, frame_count=80, speed=0.25)
        fabric = stiff_straight_yarns(law, 1.0e6)
        simulation = Simulation(bias_extension.bias_extension(parameters, fabric))
        curves = bias_extension.record(parameters, fabric, simulation.setup.sheet.blank)
        simulation.run([curves])
        c = curves.columns
        force = 0.5 * (c["force_n"] + c["fixed_clamp_force_n"])
        for angle, found in results.items():
            expected = np.interp(angle, c["kinematic_angle_deg"], c["closed_form_force_n"])
            # five frames around the angle: the clamps' forces ring by some per cent
            near = np.argsort(np.abs(c["kinematic_angle_deg"] - angle))[:5]
            found.append((
                np.interp(angle, c["kinematic_angle_deg"], c["zone_c_angle_deg"]),
                np.interp(angle, c["kinematic_angle_deg"], c["zone_b_angle_deg"]),
                np.abs(c["zone_a_angle_deg"]).max(), (force / c["closed_form_force_n"])[near].mean() * expected,
                expected,
            ))  # fmt: skip
        energies = simulation.frame.energies
        assert energies["hourglass"] < 0.02 * energies["internal"]
        assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
    for angle, found in results.items():
        central, half, clamped, force, expected = np.array(found).T
        case.text(f"At a kinematic angle of {angle:g} degrees:")
        orders = case.convergence("angle of zone C", "deg", sizes, central, angle)
        case.convergence("angle of zone B", "deg", sizes, half, 0.5 * angle)
        force_orders = case.convergence("force", "N", sizes, force, expected[0])
        assert np.all(np.diff(np.abs(central - angle)) < 0.0)
        assert orders[-1] > 0.4 and force_orders[-1] > 0.4
        assert abs(central[-1] - angle) < 0.07 * angle
        assert abs(half[-1] - 0.5 * angle) < 0.07 * 0.5 * angle
        assert clamped[-1] < 0.5
        assert force[-1] == pytest.approx(expected[0], rel=0.15)
    case.text(
        "At the edges of the zones the yarns kink; here the edges run along the diagonals of the elements, and the "
        "mesh needs one element to turn a kink into uniform shear. The strip then behaves as if the clamps were "
        "about one element further apart: an error of first order, limited from below by the stretch of the yarns."
    )


@pytest.mark.parametrize("yarn", ["warp", "weft"])
def test_cantilever(yarn, manual):
    """Warp four times as stiff in bending as weft; the overhang is twice the bending length of each."""
    case = manual(
        "Fabric tests", f"Cantilever (Peirce), strip along the {yarn}",
        known="Heavy elastica $\\theta''=-(w/D)\\,s\\cos\\theta$, $D$ 4 mN m along the warp and 1 mN m along the "
        "weft, $L=2(D/w)^{1/3}$: the chord hangs at 41.49 degrees. Peirce's formula gives $1.057\\,D$ there.",
    )  # fmt: skip
    bending = YarnBending(warp=4.0e-3, weft=1.0e-3, twist=1.0e-3)
    fabric = glass_polypropylene().model_copy(update={"bending": bending})
    weight = fabric.areal_density * cantilever.GRAVITY
    stiffness = getattr(bending, yarn)
    length = 2.0 * (stiffness / weight) ** (1.0 / 3.0)
    low, high = 0.5, 1.5
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if heavy_elastica(middle)[0] < 8.0 else (low, middle)
    exact = np.degrees(heavy_elastica(low)[1])
    angles, recovered, rows = [], [], []
    counts = (6, 12, 24)
    for count in counts:
        parameters = CantileverParameters(
            mesh_size=length / count, width=2.0 * length / count, yarn=yarn, threads=1, precision="float64"
        )
        simulation = Simulation(cantilever.cantilever(parameters, fabric))
        simulation.run()
        found = cantilever.findings(parameters, fabric, simulation)
        assert found["input_bending_stiffness_n_m"] == stiffness
        angles.append(found["chord_angle_deg"])
        recovered.append(found["elastica_bending_stiffness_n_m"])
        rows.append([1e3 * length / count, found["peirce_over_input"], found["elastica_over_input"]])
        # the clamp carries the strip at rest
        assert simulation.frame.support_force[0, 2] == pytest.approx(weight * length * parameters.width, rel=1e-3)
    orders = case.convergence("chord angle", "deg", length / np.array(counts), angles, exact)
    case.convergence("bending stiffness by the elastica", "N m", length / np.array(counts), recovered, stiffness)
    case.table(["element size [mm]", "Peirce's formula over input", "elastica over input"], rows)
    case.text("The formula in $\\cos(\\theta/2)/8\\tan\\theta$ differs from the elastica by 5.7 % at this angle.")
    assert np.all(orders > 1.7)
    assert angles[-1] == pytest.approx(exact, abs=0.1)
    assert recovered[-1] == pytest.approx(stiffness, rel=5e-3)
