"""Energies of the built-in unit cells other than the plain weave, per reference area (docs/theory.md, section 2).

Each is a function of its parameters, the stretches, the shear angle and the unknowns, in double precision, like the
energy of a user-defined cell.
"""

from typing import Any

import warp as wp
from warp import float64 as real

# --- weaves with floats -----------------------------------------------------------------------------------------------


@wp.func
def bar_energy(elongation: real, tensile: real, compressive: real):
    """1/2 k e^2 of an elongation or strain e, with the stiffness for its sign."""
    return real(0.5) * wp.where(elongation > real(0.0), tensile, compressive) * elongation * elongation


@wp.func
def yarn_energies(p: Any, k: int, stretch: real, w: real, float_strain: real):
    """Axial and bending energy per reference area of yarn k from a crossover's float to its next inflection point."""
    length = p.chord_length[k]
    spacing = p.half_spacing[k]
    height = p.crimp_height[k]
    # the crimped beam takes the part of the elongation that the float does not
    x = spacing + (stretch - real(1.0)) * (spacing + p.float_length[k]) - float_strain * p.float_length[k]
    h = height + w
    # differences of nearly equal numbers: double precision leaves 2e-16 of the strain, and the derivatives are short
    elongation = wp.sqrt(x * x + h * h) - wp.sqrt(spacing * spacing + height * height)
    rotation = wp.atan2(h, x) - wp.atan2(height, spacing)
    scale = real(1.0) / (length * p.area)
    axial = bar_energy(elongation, p.axial_stiffness[k] * scale, p.compressive_stiffness[k] * scale)
    share = p.float_length[k] / p.area
    axial = axial + bar_energy(float_strain, p.axial_stiffness[k] * share, p.compressive_stiffness[k] * share)
    return wp.vec2d(axial, real(1.5) * p.bending_stiffness[k] * scale * rotation * rotation)


@wp.func
def floats_closing(p: Any, q: Any):
    """Penetration of warp and weft at the contact, where it is active [m]."""
    closing = -p.height_scale * (q[0] + q[1])
    return wp.where(p.unilateral > real(0.0), wp.max(closing, real(0.0)), closing)


@wp.func
def floats_energies(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Axial warp, axial weft, bending of the yarns, contact; q: scaled height changes, strains of the floats."""
    warp = yarn_energies(p, 0, warp_stretch, p.height_scale * q[0], q[2])
    weft = yarn_energies(p, 1, weft_stretch, p.height_scale * q[1], q[3])
    closing = floats_closing(p, q)
    contact = real(0.5) * (p.contact_stiffness / p.area) * closing * closing
    return wp.vec4d(warp[0], weft[0], warp[1] + weft[1], contact)


@wp.func
def floats_crossover_pressure(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Contact force per reference area [N/m^2]."""
    return p.contact_stiffness * floats_closing(p, q) / p.area


# --- unidirectional tape with stitches --------------------------------------------------------------------------------


@wp.func
def stitch_leg_strain(p: Any, warp_stretch: real, weft_stretch: real, sine: real):
    """Strain of a diagonal that extends ``stitch_pitch`` along the tows and ``tow_spacing`` across.

    ``sine`` is that of the shear angle, with opposite sign for the other diagonal.
    """
    along = p.stitch_pitch * warp_stretch
    across = p.tow_spacing * weft_stretch
    squared = p.stitch_pitch * p.stitch_pitch + p.tow_spacing * p.tow_spacing
    length = wp.sqrt(along * along + across * across + real(2.0) * along * across * sine)
    return length / wp.sqrt(squared) - real(1.0)


@wp.func
def tape_energies(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """Tows, stitches, and interaction of tows; q: thread that slips from one leg to the other, as a strain."""
    sine = wp.sin(shear_angle)
    tow = bar_energy(warp_stretch - real(1.0), p.tow_stiffness, p.tow_compressive_stiffness)
    first = wp.max(stitch_leg_strain(p, warp_stretch, weft_stretch, sine) - p.stitch_slack - q[0], real(0.0))
    second = wp.max(stitch_leg_strain(p, warp_stretch, weft_stretch, -sine) - p.stitch_slack + q[0], real(0.0))
    half = real(0.5)
    stitches = half * p.stitch_stiffness * (first * first + second * second) + half * p.slip_stiffness * q[0] * q[0]
    across = bar_energy(weft_stretch - real(1.0), p.transverse_stiffness, p.transverse_compressive_stiffness)
    return wp.vec3d(tow, stitches, across)


# --- linear membrane --------------------------------------------------------------------------------------------------


@wp.func
def membrane_energy(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    """1/2 C11 e1^2 + C12 e1 e2 + 1/2 C22 e2^2 with e = stretch - 1."""
    warp = warp_stretch - real(1.0)
    weft = weft_stretch - real(1.0)
    return (
        real(0.5) * (p.warp_stiffness * warp * warp + p.weft_stiffness * weft * weft)
        + p.coupling_stiffness * warp * weft
    )


@wp.func
def membrane_gradient(p: Any, warp_stretch: real, weft_stretch: real, shear_angle: real, q: Any):
    warp = warp_stretch - real(1.0)
    weft = weft_stretch - real(1.0)
    return wp.vec3d(
        p.warp_stiffness * warp + p.coupling_stiffness * weft,
        p.coupling_stiffness * warp + p.weft_stiffness * weft,
        real(0.0),
    )
