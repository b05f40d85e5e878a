"""Friction laws of tools on the sled, whose pressure and speed are known: their own curves come back."""

import numpy as np
import pytest

from weavesim import Coulomb, PressureFriction, Simulation, StribeckFriction, ViscousFilm
from weavesim.fabric.presets import glass_polypropylene
from weavesim.scenes.laboratory.sled import SledParameters, normal_force, sled

# A film of 60 Pa s/m, which the step carries to 1 %.
FILM, STRIBECK = ViscousFilm(0.06, 1e-3, 0.1), (0.0, 1e-5, 1e-4, 1e-3)
COEFFICIENTS = 0.35, 0.15, 0.1, 0.3


def pulled(friction, frames, *, samples: str = "nodes", **given):
    """Mean force over weight while the speed is constant, its pressure [Pa], its speed [m/s], the last frame."""
    frames.all.clear()
    parameters = SledParameters(mesh_size=0.03, frame_count=24, threads=1, **given)
    setup = sled(parameters, friction=friction)
    (world,) = setup.worlds
    if samples != "nodes":
        dynamics = world.dynamics.model_copy(update={"contact_samples": samples})
        setup = setup.model_copy(update={"worlds": (world.model_copy(update={"dynamics": dynamics}),)})
    simulation = Simulation(setup)
    simulation.run([frames])
    weight = normal_force(parameters, glass_polypropylene())
    way = np.array([frame.drive_displacement[0] for frame in frames.all]) / parameters.distance
    force = np.array([frame.drive_force[0] for frame in frames.all])
    steady = (way > 0.3) & (way < 0.8)
    assert steady.sum() > 5
    share = float(force[steady].mean()) / weight
    return share, weight / parameters.side**2, parameters.speed, simulation


@pytest.mark.parametrize("samples", ["nodes", "surface"])
@pytest.mark.parametrize(
    ("friction", "known"),
    [
        (PressureFriction((0.0, 1000.0), (0.4, 0.1)), lambda pressure, speed: 0.4 - 3e-4 * pressure),
        (
            StribeckFriction(STRIBECK, COEFFICIENTS, 0.02),
            lambda pressure, speed: np.interp(0.02 * speed / pressure, STRIBECK, COEFFICIENTS),
        ),
        (FILM, lambda pressure, speed: 0.1 + 60.0 * speed / pressure),
    ],
    ids=["pressure", "Stribeck", "film"],
)
def test_a_sled_gives_the_law_of_its_table_back(friction, known, samples, frames):
    share, pressure, speed, simulation = pulled(friction, frames, samples=samples)
    assert share == pytest.approx(known(pressure, speed), rel=2e-3)
    energies = frames.all[-1].energies
    assert abs(energies["balance_error"]) < 1e-4 * energies["supplied"]
    assert [doubt for doubt in simulation.doubts() if doubt.guard == "tool_friction"] == []


def test_one_coefficient_and_a_flat_table_are_the_same(frames):
    flat = pulled(PressureFriction((0.0, 1e4), (0.25, 0.25)), frames)[0]
    assert flat == pytest.approx(pulled(Coulomb(0.25), frames)[0], rel=1e-5)


def test_use_beyond_a_table_is_told_with_place_and_time(frames):
    *_, simulation = pulled(PressureFriction((1000.0, 2000.0), (0.4, 0.1)), frames)
    (doubt,) = (doubt for doubt in simulation.doubts() if doubt.guard == "tool_friction")
    assert "tool table: the friction table is used beyond its ends" in doubt.text and "of pressure" in doubt.text
    assert doubt.sheet == "sheet" and np.abs(doubt.place).max() <= 0.032 and 0.0 < doubt.time < 0.05
    # nodes are pressed by up to twice the pressure, or not at all, while the sled is laid down
    assert doubt.value == pytest.approx(1000.0, rel=0.05)


def test_a_film_that_the_step_cannot_carry_is_told_before_the_run(frames):
    simulation = Simulation(sled(SledParameters(mesh_size=0.03), friction=ViscousFilm(100.0, 1e-4)))
    assert any("the time step can carry" in doubt.text for doubt in simulation.prepare().guards.first)


@pytest.mark.verification
def test_study_of_laws_on_the_sled(manual, frames):
    rows = []
    for speed in (0.05, 0.1, 0.2):
        for name, friction, known in (
            ("Stribeck", StribeckFriction(STRIBECK, COEFFICIENTS, 0.1),
             lambda pressure, speed: np.interp(0.1 * speed / pressure, STRIBECK, COEFFICIENTS)),
            ("film", FILM, lambda pressure, speed: 0.1 + 60.0 * speed / pressure),
        ):  # fmt: skip
            share, pressure, speed, _ = pulled(friction, frames, speed=speed)
            rows.append([f"{name}, {speed:g} m/s", known(pressure, speed), share])
    for mass in (0.1, 0.2, 0.4):
        friction = PressureFriction((0.0, 2000.0), (0.4, 0.1))
        share, pressure, _, _ = pulled(friction, frames, mass=mass)
        rows.append([f"pressure, {pressure:.0f} Pa", 0.4 - 1.5e-4 * pressure, share])
    for _, known, found in rows:
        assert found == pytest.approx(known, rel=2e-3)
    case = manual(
        "Contact", "Friction laws of tools on a sled",
        known="A sled of known weight is pulled over a table at constant speed (ISO 8295): force over weight is the "
        "law's coefficient at this pressure and speed, mu(p), mu(eta v/p), or mu + eta v/(h p).",
    )  # fmt: skip
    case.table(["law", "known", "force over weight"], rows)
