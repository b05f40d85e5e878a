"""The page of what was measured: one laboratory's picture frame in, its bias extension out, and where yarns slip."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from scripts.shared.report import table
from scripts.validation_pages.laboratories import NAMES, rubbing, sheared_as_in
from scripts.validation_pages.shear_curves import forming_part
from weavesim import __version__
from weavesim.fabric.closed_forms import moment_along
from weavesim.fabric.fabric import Fabric
from weavesim.fabric.presets import glass_polypropylene_hkust
from weavesim.fabric.presets.cao2008 import CITATION, FOLDER, frame_curve
from weavesim.output.pictures.style import (
    INK,
    LINE_COLOURS,
    MEASURED,
    add_legend,
    new_axes,
    new_figure,
    write_picture,
)
from weavesim.run.simulation import Simulation
from weavesim.scenes.bias_extension import (
    BiasExtensionParameters,
    bias_extension,
    closed_form_force,
    kinematic_angle,
    record,
    zone_areas,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "images" / "measured"
# HKUST's specimen, and the long one of INSA-Lyon and Northwestern [m].
HKUST = {"length": 0.23, "width": 0.115, "largest_angle": 50.3, "frame_count": 76}
LONG = {"length": 0.45, "width": 0.15, "largest_angle": 55.3, "frame_count": 84}
# Elements across the width.
COUNTS, LONG_COUNTS = (12, 24, 36), (12, 24)
DISPLACEMENTS = (2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 38.0)
LONG_DISPLACEMENTS = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 105.0)
# Where friction that conditioning took away is read off [mm].
FITTED_AT = 10.0
SLIP = 2.0  # difference of the angle from which on slip is said to matter [degrees]
# The authors trust the angle from the crosshead up to here in the bias extension; locking begins near the second.
TRUSTED, LOCKING = 30.0, 45.0


@dataclass(frozen=True)
class Series:
    """A computed or measured test: displacement [mm], force [N], angle of the central zone [degrees], (n,) each."""

    displacement: np.ndarray
    force: np.ndarray
    angle: np.ndarray
    half_angle: np.ndarray

    def at(self, displacement: float | Sequence[float] | np.ndarray, what: str = "force") -> np.ndarray:
        return np.interp(displacement, self.displacement, getattr(self, what))


def run(fabric: Fabric, count: int, specimen: Mapping[str, float], speed: float = 0.25) -> Series:
    """A bias extension with ``count`` elements across."""
    parameters = BiasExtensionParameters(**specimen, mesh_size=specimen["width"] / count, speed=speed)
    simulation = Simulation(bias_extension(parameters, fabric))
    curves = record(parameters, fabric, simulation.setup.sheet.blank)
    simulation.run([curves])
    c = curves.columns
    force = 0.5 * (c["force_n"] + c["fixed_clamp_force_n"])
    print(
        f"{count} elements across, {speed} m/s: {force[-1]:.2f} N, {c['zone_c_angle_deg'][-1]:.2f} degrees", flush=True
    )
    return Series(c["displacement_mm"], force, c["zone_c_angle_deg"], c["zone_b_angle_deg"])


def measured_forces() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement [mm] and force [N] of HKUST's bias extension at 20 degrees C, by speed, up to where each ends."""
    columns = read_figure("bias_hkust_115x230.csv")
    result = {}
    for speed in ("10mm/min", "500mm/min"):
        force = columns[f"force 20C {speed} [N]"]
        read = np.isfinite(force)
        result[speed.replace("mm/", " mm/")] = columns["displacement [mm]"][read], force[read]
    return result


def read_figure(name: str) -> dict[str, np.ndarray]:
    """Columns of a figure by their header; the curves of a figure end at different rows, with nan behind them."""
    with open(FOLDER / name, encoding="utf-8", newline="") as file:
        rows = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows[1:]])
    return dict(zip(rows[0], values.T, strict=True))


def closed_forms(specimen: Mapping[str, float], fabric: Fabric, displacement: np.ndarray) -> np.ndarray:
    """Force of inextensible yarns [N] at displacements [mm]."""
    parameters = BiasExtensionParameters(**specimen)
    return np.array([closed_form_force(parameters, fabric, 1e-3 * d) for d in displacement])


def raw_closed_form(displacement: np.ndarray) -> np.ndarray:
    """The same with HKUST's points joined by straight lines."""
    angle, force = frame_curve("hkust")
    moment = force * np.cos(angle)
    parameters = BiasExtensionParameters(**HKUST)
    _, half, central = zone_areas(parameters)
    result = []
    for d in displacement:
        gamma, rate = kinematic_angle(parameters, 1e-3 * d)
        m, m_half = np.interp([gamma, 0.5 * gamma], angle, moment)
        result.append((central * m + 0.5 * half * m_half) * rate)
    return np.array(result)


def band(displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest closed form with the frames of the four other laboratories, where one reaches the angle [N]."""
    parameters = BiasExtensionParameters(**HKUST)
    angle = np.array([kinematic_angle(parameters, 1e-3 * d)[0] for d in displacement])
    forces = []
    for laboratory in NAMES:
        if laboratory != "hkust":
            fabric = sheared_as_in(laboratory, glass_polypropylene_hkust())
            reached = angle <= frame_curve(laboratory)[0][-1]
            forces.append(np.where(reached, closed_forms(HKUST, fabric, displacement), np.nan))
    stack = np.array(forces)
    some = ~np.isnan(stack).all(axis=0)
    low, high = np.full(len(angle), np.nan), np.full(len(angle), np.nan)
    low[some], high[some] = np.nanmin(stack[:, some], axis=0), np.nanmax(stack[:, some], axis=0)
    return low, high


def friction_at(displacement: float, measured: float, fabric: Fabric) -> float:
    """Moment of friction in both zones [N/m] that closes the gap between closed form and measurement there."""
    parameters = BiasExtensionParameters(**HKUST)
    _, rate = kinematic_angle(parameters, 1e-3 * displacement)
    _, half, central = zone_areas(parameters)
    missing = measured - float(closed_forms(HKUST, fabric, np.array([displacement]))[0])
    return missing / ((central + 0.5 * half) * rate)


def lagging_displacement(displacement: float) -> float:
    """Displacement [mm] at which kinematics has the angle that the long specimen had at the same kinematic angle."""
    columns = read_figure("bias_angle_150x450.csv")
    mean = 0.5 * (columns["image analysis [deg]"] + columns["manual [deg]"])
    known = np.isfinite(mean)
    parameters = BiasExtensionParameters(**HKUST)
    angle = np.degrees(kinematic_angle(parameters, 1e-3 * displacement)[0])
    seen = np.interp(angle, columns["theoretical [deg]"][known], mean[known])
    path = np.linspace(0.0, displacement, 351)
    return float(np.interp(seen, np.degrees([kinematic_angle(parameters, 1e-3 * d)[0] for d in path]), path))


def measured_page() -> tuple[str, list[str]]:
    """The page, and the requirements that are not met."""
    parts = [
        "# Validation against measurements",
        f"Written by `python scripts/validation.py measured` on {date.today().isoformat()} with weavesim "
        f"{__version__}. Measured: {CITATION}; the numbers are in `weavesim/fabric/data`. The cloth is the commingled "
        "glass/polypropylene plain weave TPEET22XXX.",
        "The laboratories of that round robin scatter by about 40 % among each other. Its authors trust the angle from "
        f"the crosshead up to {TRUSTED:g}° in the bias extension, and see locking begin near {LOCKING:g}°. An "
        "agreement that is better than the scatter is evidence only where input and target are of one laboratory: "
        "so they are here, and nothing is fitted unless it is said.",
    ]
    first, failed = bias_part()
    second, failed_too = slip_part()
    third, _ = forming_part()
    return "\n\n".join([*parts, *first, *second, *third]) + "\n", failed + failed_too


def bias_part() -> tuple[list[str], list[str]]:
    """HKUST's picture frame in, its bias extension out."""
    fabric = glass_polypropylene_hkust()
    runs = {count: run(fabric, count, HKUST) for count in COUNTS}
    slow = run(fabric, COUNTS[1], HKUST, speed=0.125)
    measured = measured_forces()
    x = np.array(DISPLACEMENTS)
    target = np.interp(x, *measured["10 mm/min"])
    fast = np.interp(x, *measured["500 mm/min"])
    known, raw, (low, high) = closed_forms(HKUST, fabric, x), raw_closed_form(x), band(x)
    limit = friction_at(FITTED_AT, float(np.interp(FITTED_AT, *measured["10 mm/min"])), fabric)
    rubbed = run(rubbing(fabric, limit), COUNTS[1], HKUST)
    kinematic = np.degrees([kinematic_angle(BiasExtensionParameters(**HKUST), 1e-3 * d)[0] for d in x])
    sizes = [f"{1e3 * HKUST['width'] / count:.1f} mm" for count in COUNTS]
    forces = [
        [f"{d:g}", f"{g:.1f}", f"{target[k]:.2f}", f"{fast[k]:.2f}", *(f"{runs[n].at(d):.2f}" for n in COUNTS),
         f"{known[k]:.2f}", f"{raw[k]:.2f}",
         "–" if np.isnan(low[k]) else f"{low[k]:.1f} to {high[k]:.1f}", f"{rubbed.at(d):.2f}"]
        for k, (d, g) in enumerate(zip(x, kinematic, strict=True))
    ]  # fmt: skip
    angles = [
        [f"{d:g}", f"{g:.1f}", *(f"{runs[n].at(d, 'angle'):.1f}" for n in COUNTS), f"{0.5 * g:.1f}",
         *(f"{runs[n].at(d, 'half_angle'):.1f}" for n in COUNTS)]
        for d, g in zip(x, kinematic, strict=True)
    ]  # fmt: skip
    draw_forces(runs, rubbed, measured)
    lagging = float(runs[COUNTS[-1]].at(lagging_displacement(35.0)))
    finest, middle = runs[COUNTS[-1]], runs[COUNTS[1]]
    trusted = (kinematic > 20.0) & (kinematic <= LOCKING)
    small = kinematic <= 12.0
    gap = target - finest.at(x)
    ratio = finest.at(x) / target
    rubbed_ratio = rubbed.at(x) / target
    speed_change = float(np.abs(slow.at(x) - middle.at(x)).max())
    last_change = np.abs(finest.at(x) / middle.at(x) - 1.0)
    rate_share = float(np.abs(fast / target - 1.0)[trusted].max())
    gates = [
        (f"force from 20° to {LOCKING:g}°, finest mesh over measured at 10 mm/min",
         f"{ratio[trusted].min():.2f} to {ratio[trusted].max():.2f}", "0.75 to 1.25",
         bool(ratio[trusted].min() >= 0.75 and ratio[trusted].max() <= 1.25)),
        (f"angle of zone C up to {TRUSTED:g}°, finest mesh less kinematics",
         f"{np.abs(finest.at(x, 'angle') - kinematic)[kinematic <= TRUSTED].max():.2f}°", "1°",
         bool(np.abs(finest.at(x, "angle") - kinematic)[kinematic <= TRUSTED].max() <= 1.0)),
        (f"force from 20° to {LOCKING:g}°, two finest meshes", f"{100 * last_change[trusted].max():.1f} %", "10 %",
         bool(last_change[trusted].max() <= 0.1)),
        ("speed halved, largest change of the force", f"{speed_change:.3f} N", "0.1 N", speed_change <= 0.1),
        ("force below 12°, finest mesh over measured at 10 mm/min", f"{ratio[small].min():.2f} to "
         f"{ratio[small].max():.2f}", "0.75 to 1.25", bool(ratio[small].min() >= 0.75)),
    ]  # fmt: skip
    head = ["displacement [mm]", "kinematic angle [°]", "measured, 10 mm/min", "500 mm/min",
            *(f"weavesim, {size}" for size in sizes), "closed form", "closed form of the raw points",
            "closed form, other laboratories", f"{sizes[1]}, with friction"]  # fmt: skip
    text = [
        "## HKUST's picture frame in, HKUST's bias extension out",
        "The fabric `glass-polypropylene-hkust` has the shear curve of HKUST's frame (Fig. 28, smoothed: its points "
        "scatter by 1.2 N/m from one to the next). It is pulled as HKUST pulled it: 115 × 230 mm between the clamps, "
        "room temperature (Fig. 40). Force in N, mean of both clamps; the closed form is the power balance of "
        "inextensible yarns in three zones. The band is that closed form with the frames of the four other "
        "laboratories, of those that reach the angle.",
        "Expected of a simulation that fits, and whether it does:",
        table(["expected", "value", "bound", "holds"],
              [[text, value, bound, "yes" if holds else "**no**"] for text, value, bound, holds in gates]),
        table(head, forces),
        "![force](images/measured/bias_extension_force.png)",
        "Angle of the zones, in degrees: zone C against kinematics, zone B against half of it.",
        table(["displacement [mm]", "kinematics, C", *(f"C, {size}" for size in sizes), "kinematics, B",
               *(f"B, {size}" for size in sizes)], angles),
        "What does not fit, and why:",
        f"- **Below about 20° the measured force is higher**: by {gap[0]:.2f} N at 2 mm, {gap[x == 10][0]:.2f} N at "
        f"10 mm and {gap[x == 20][0]:.2f} N at 20 mm, where the frame has next to no force at first. HKUST sheared its "
        "frame specimens several times before the test and took out the fringe yarns; the bias specimens were new. "
        "Friction that conditioning took away would leave such a gap: read off at "
        f"{FITTED_AT:g} mm it is {limit:.1f} N/m, and the frames of the other laboratories jump to 3 to 17 N/m within "
        "their first degree. But **a constant friction does not fit**: with it (last column, one number fitted to the "
        f"target) the force is {rubbed_ratio[0]:.1f} times the measured one at 2 mm, and "
        f"{rubbed_ratio[x == 15][0]:.2f} to {rubbed_ratio[(x >= 15) & (x <= 25)].max():.2f} times from 15 to 25 mm. "
        "The gap builds up over 10 mm and is gone at 25 mm, whatever the reason; no unloading was published that would "
        "tell.",
        f"- **Above about 40° the computed force is higher**: {ratio[x == 35][0]:.2f} times the measured one at 35 mm "
        f"and {ratio[-1]:.2f} times at 38 mm on the finest mesh; the closed form of inextensible yarns is "
        f"{known[-2] / target[-2]:.2f} and {known[-1] / target[-1]:.2f} times. In a longer specimen the angle was "
        "measured too, and falls behind kinematics by slip (next section). If the angle here lagged by as much, the "
        f"finest run would give {lagging:.1f} N at 35 mm, {lagging / target[-2]:.2f} times the measured force: so slip "
        "can explain the difference, and is less here than there; the angle of this specimen was not measured.",
        f"- **The mesh**: the angle at the edges of the zones jumps, and a mesh spreads that over an element; forces "
        f"converge from below, by {100 * last_change[x == 35][0]:.0f} % at 35 mm between the two finest. With the "
        f"coarsest mesh the force at 35 mm would be {runs[COUNTS[0]].at(35.0) / target[-2]:.2f} times the measured "
        "one: an agreement by accident.",
        f"- **The rate**: HKUST's own forces at 500 mm/min are up to {100 * rate_share:.0f} % lower than at 10 mm/min "
        "in that range. The model has no rate.",
        "Raw bias forces of the paper's Figs. 38, 41 and 43 contradict its normalised ones through its own equations "
        "by factors of 2.3 to 5.2; they are not used.",
    ]  # fmt: skip
    return text, [what for what, _, _, holds in gates[:-1] if not holds]


def draw_forces(
    runs: Mapping[int, Series], rubbed: Series, measured: Mapping[str, tuple[np.ndarray, np.ndarray]]
) -> None:
    """Force over displacement, and the ratio to the measured one."""
    x = np.linspace(1.0, 38.0, 75)
    low, high = band(x)
    figure = new_figure(9.0, 4.6)
    axes = new_axes(
        figure, 1, 1, 1, title="Bias extension 115 × 230 mm", xlabel="displacement [mm]", ylabel="force [N]"
    )
    axes.fill_between(x, low, high, color="#e6e8ec", label="closed form, frames of four other laboratories")
    for k, (count, series) in enumerate(runs.items()):
        axes.plot(series.displacement, series.force, color=LINE_COLOURS[(0, 2, 4)[k]], linewidth=1.6,
                  label=f"weavesim, {1e3 * HKUST['width'] / count:.1f} mm")  # fmt: skip
    axes.plot(rubbed.displacement, rubbed.force, color=LINE_COLOURS[1], linewidth=1.2,
              label="with friction fitted at 10 mm")  # fmt: skip
    axes.plot(x, closed_forms(HKUST, glass_polypropylene_hkust(), x), color=INK, linestyle=(0, (4, 3)), linewidth=1.2,
              label="closed form, HKUST's frame")  # fmt: skip
    for (speed, (place, force)), marker in zip(measured.items(), "os", strict=True):
        axes.plot(place, force, color=MEASURED, marker=marker, markersize=3.5, linestyle="none",
                  fillstyle="full" if marker == "o" else "none", label=f"measured by HKUST, {speed}")  # fmt: skip
    axes.set(xlim=(0.0, 38.5), ylim=(0.0, 42.0))
    add_legend(axes, loc="upper left")
    save(figure, "bias_extension_force")


def slip_part() -> tuple[list[str], list[str]]:
    """The angles of the 150 x 450 mm specimen: kinematics against yarns that slip."""
    columns = read_figure("bias_angle_150x450.csv")
    place, image, manual = columns["displacement [mm]"], columns["image analysis [deg]"], columns["manual [deg]"]
    fabric = glass_polypropylene_hkust()
    runs = {count: run(fabric, count, LONG) for count in LONG_COUNTS}
    x = np.array(LONG_DISPLACEMENTS)
    parameters = BiasExtensionParameters(**LONG)
    kinematic = np.degrees([kinematic_angle(parameters, 1e-3 * d)[0] for d in x])
    seen = np.interp(x, place, np.where(np.isnan(image), 0.0, image))
    by_hand = np.interp(x, place, np.where(np.isnan(manual), 0.0, manual))
    finest = runs[LONG_COUNTS[-1]]
    mean = 0.5 * (seen + by_hand)
    slip = finest.at(x, "angle") - mean
    begin = int(np.argmax(kinematic - mean > SLIP))
    rows = [
        [f"{d:g}", f"{kinematic[k]:.1f}", *(f"{runs[n].at(d, 'angle'):.1f}" for n in LONG_COUNTS), f"{seen[k]:.1f}",
         f"{by_hand[k]:.1f}", f"{kinematic[k] - mean[k]:.1f}", f"{slip[k]:.1f}"]
        for k, d in enumerate(x)
    ]  # fmt: skip
    sizes = [f"{1e3 * LONG['width'] / count:.1f} mm" for count in LONG_COUNTS]
    draw_angles(runs, place, image, manual)
    behind = np.abs(finest.at(x, "angle") - kinematic)[kinematic <= TRUSTED].max()
    moment = [float(moment_along(fabric, np.linspace(0.0, np.radians(a), 50))[-1]) for a in (kinematic[7], mean[7])]
    text = [
        "## Where yarns slip: the angle of a 150 × 450 mm specimen",
        "In Fig. 36 the angle in the central zone was measured, by image analysis and by hand, and falls behind "
        "kinematics without slip. A continuous shell has warp and weft in one material point: its yarns stretch and "
        "bend, but never slide past each other, so it has to follow kinematics. Angles in degrees; the last two "
        "columns are what kinematics and the simulation have above the mean of both measurements.",
        table(["displacement [mm]", "kinematics", *(f"weavesim, {size}" for size in sizes), "image analysis", "by hand",
               "kinematics less measured", "weavesim less measured"], rows),
        "![angle](images/measured/bias_extension_angle.png)",
        f"**This is a limit of the model.** The difference to kinematics is {(kinematic - mean)[0]:.1f}° at the first "
        f"reading already, exceeds {SLIP:g}° from {x[begin]:g} mm ({kinematic[begin]:.0f}°) on, and is "
        f"{(kinematic - mean)[x == 80][0]:.1f}° at 80 mm and {(kinematic - mean)[x == 105][0]:.1f}° at 105 mm. The "
        f"simulation stays within {behind:.1f}° of kinematics up to {TRUSTED:g}°; what it lies below at larger angles "
        f"({(kinematic - finest.at(x, 'angle'))[-1]:.1f}° at 105 mm) is stretch of the yarns, not slip. At 80 mm the "
        f"frame's moment at the computed angle is {moment[0] / moment[1]:.1f} times that at the measured one: a force "
        "that is calculated from kinematics counts slip as shear. In forming, yarns that are held at both ends or "
        "pressed between tools slip less than those of a strip with free edges; how much less, these data do not say.",
    ]  # fmt: skip
    return text, [] if behind <= 1.5 else ["the long specimen follows kinematics up to 30°"]


def draw_angles(runs: Mapping[int, Series], place: np.ndarray, image: np.ndarray, manual: np.ndarray) -> None:
    """Angle over displacement."""
    parameters = BiasExtensionParameters(**LONG)
    figure = new_figure(9.0, 4.2)
    axes = new_axes(figure, 1, 1, 1, title="Bias extension 150 × 450 mm", xlabel="displacement [mm]",
                    ylabel="angle of the central zone [degrees]")  # fmt: skip
    x = np.linspace(0.0, 105.0, 106)
    axes.plot(x, np.degrees([kinematic_angle(parameters, 1e-3 * d)[0] for d in x]), color=INK, linestyle=(0, (4, 3)),
              label="kinematics, no slip")  # fmt: skip
    for k, (count, series) in enumerate(runs.items()):
        axes.plot(series.displacement, series.angle, color=LINE_COLOURS[(0, 2)[k]],
                  label=f"weavesim, {1e3 * LONG['width'] / count:.1f} mm")  # fmt: skip
    for name, values, marker in (("image analysis", image, "o"), ("by hand", manual, "s")):
        axes.plot(place, values, color=MEASURED, marker=marker, markersize=3.5, linestyle="none",
                  fillstyle="full" if marker == "o" else "none", label=f"measured, {name}")  # fmt: skip
    axes.set(xlim=(0.0, 106.0), ylim=(0.0, 57.0))
    add_legend(axes, loc="upper left")
    save(figure, "bias_extension_angle")


def save(figure: Figure, name: str) -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    write_picture(figure, PICTURES / f"{name}.png")
