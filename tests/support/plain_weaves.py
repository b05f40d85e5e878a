"""Plain weaves at random, their response in the quantities of the half cell, and an independent reference for it."""

from dataclasses import dataclass

import numpy as np

from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.response import UnitCellResponse, respond

INCREMENT_COUNT = 50


@dataclass(frozen=True)
class HalfCell:
    """The response in the quantities of the half cell: forces [N], energies [J], K = dF/du [N/m]."""

    response: UnitCellResponse
    height_change: np.ndarray
    force: np.ndarray
    force_per_width: np.ndarray
    crossover_force: np.ndarray
    energy: np.ndarray
    tangent: np.ndarray
    residual: np.ndarray


def half_cell(cells, stretch, **options) -> HalfCell:
    """``respond`` for plain weaves: F_1 = 2 L_2 n_1, Pi = 2 L_1 L_2 psi, K_kl = dF_k/du_l."""
    response = respond(cells, stretch, **options)
    spacing = np.array([cell.half_spacing for cell in ([cells] if isinstance(cells, PlainWeave) else cells)])
    across = 2.0 * spacing[:, ::-1]
    stiffness = response.tangent[:, :2, :2] * across[:, :, None] / spacing[:, None, :]
    assert np.all(response.moment == 0.0)
    assert np.all(response.tangent[:, 2] == 0.0)
    return HalfCell(
        response=response,
        height_change=response.unknowns,
        force=response.force_per_width * across,
        force_per_width=response.force_per_width,
        crossover_force=response.crossover_force,
        energy=response.energy * (2.0 * spacing.prod(axis=1))[:, None],
        tangent=stiffness[:, [0, 0, 1], [0, 1, 1]],
        residual=response.residual,
    )


def random_cell(rng: np.random.Generator, **given) -> PlainWeave:
    """A cell with stiffnesses over orders of magnitude and crimp from slight to steep."""
    half_spacing = 10.0 ** rng.uniform(-3.2, -2.2, 2)
    area = 10.0 ** rng.uniform(-7.0, -5.5, 2)
    modulus = 10.0 ** rng.uniform(8.0, 11.0, 2)
    second_moment = area**2 / 12.0 * 10.0 ** rng.uniform(-4.0, 0.0, 2)
    values = {
        "warp_modulus": modulus[0], "weft_modulus": modulus[1], "contact_modulus": 10.0 ** rng.uniform(5.0, 9.0),
        "warp_cross_section": area[0], "weft_cross_section": area[1],
        "contact_cross_section": 10.0 ** rng.uniform(-7.0, -5.0),
        "warp_second_moment": second_moment[0], "weft_second_moment": second_moment[1],
        "warp_half_spacing": half_spacing[0], "weft_half_spacing": half_spacing[1],
        "crossover_height": rng.uniform(0.02, 0.6) * half_spacing.min(),
        "warp_crimp_share": rng.uniform(0.1, 0.9),
        "contact": str(rng.choice(["bilateral", "unilateral"])),
    }  # fmt: skip
    return PlainWeave(**(values | given))


def swapped(cell: PlainWeave) -> PlainWeave:
    """The same cell with warp and weft exchanged."""
    values = cell.model_dump()
    exchanged = {
        name.replace("warp", "we_ft").replace("weft", "warp").replace("we_ft", "weft"): value
        for name, value in values.items()
        if name != "warp_crimp_share"
    }
    return PlainWeave(**exchanged, warp_crimp_share=1.0 - cell.warp_crimp_share)


@dataclass(frozen=True)
class Reference:
    """Energy of the half cell and its derivatives by the angles and lengths of the chords, for n cells at once.

    Arrays of the yarns are (n, 2). Nothing here is shared with the kernels: angles come from atan2.
    """

    spacing: np.ndarray
    height: np.ndarray
    tensile: np.ndarray
    compressive: np.ndarray
    rotational: np.ndarray
    contact: np.ndarray
    unilateral: np.ndarray

    @classmethod
    def of(cls, cells: list[PlainWeave]) -> "Reference":
        def rows(name):
            return np.array([getattr(cell, name) for cell in cells], dtype=float)

        spacing, height = rows("half_spacing"), rows("crimp_height")
        length = np.hypot(spacing, height)
        modulus = np.array([(cell.warp_modulus, cell.weft_modulus) for cell in cells])
        area = np.array([(cell.warp_cross_section, cell.weft_cross_section) for cell in cells])
        bending = modulus * np.array([(cell.warp_second_moment, cell.weft_second_moment) for cell in cells])
        given = np.array([(c.warp_compressive_stiffness, c.weft_compressive_stiffness) for c in cells], dtype=float)
        compressive = np.where(np.isnan(given), 3.0 * bending / length**2, given)
        contact = np.array(
            [
                c.contact_stiffness_value or c.contact_modulus * c.contact_cross_section / c.crossover_height
                for c in cells
            ]
        )
        unilateral = np.array([cell.contact == "unilateral" for cell in cells])
        return cls(
            spacing, height, modulus * area / length, compressive / length, 3.0 * bending / length, contact, unilateral
        )

    def part(self, index) -> "Reference":
        return Reference(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    def _chord(self, u, w):
        x, h = self.spacing + u, self.height + w
        length = np.hypot(x, h)
        elongation = length - np.hypot(self.spacing, self.height)
        rotation = np.arctan2(h, x) - np.arctan2(self.height, self.spacing)
        stiffness = np.where(elongation > 0.0, self.tensile, self.compressive)
        return x / length, h / length, length, elongation, rotation, stiffness

    def _contact_stiffness(self, w):
        return np.where(self.unilateral & (w.sum(-1) >= 0.0), 0.0, self.contact)

    def energy(self, u, w):
        _, _, _, elongation, rotation, stiffness = self._chord(u, w)
        yarns = 0.5 * stiffness * elongation**2 + 0.5 * self.rotational * rotation**2
        return yarns.sum(-1) + 0.5 * self._contact_stiffness(w) * w.sum(-1) ** 2

    def gradient(self, u, w):
        """(dPi/du, dPi/dw), (n, 2) each."""
        cosine, sine, length, elongation, rotation, stiffness = self._chord(u, w)
        axial, turning = stiffness * elongation, self.rotational * rotation / length
        closing = self._contact_stiffness(w) * w.sum(-1)
        return axial * cosine - turning * sine, axial * sine + turning * cosine + closing[..., None]

    def size(self, u, w):
        """Of what balances in dPi/dw, and what rounding of the lengths and of w_1 + w_2 leaves of it; (n,) each."""
        cosine, sine, length, elongation, rotation, stiffness = self._chord(u, w)
        yarns = np.abs(stiffness * elongation * sine) + np.abs(self.rotational * rotation / length * cosine)
        epsilon = np.finfo(float).eps
        rounding = 8.0 * epsilon * (self.tensile * length * np.abs(sine)).max(-1)
        rounding = rounding + epsilon * self._contact_stiffness(w) * np.abs(w).sum(-1)
        return yarns.max(-1) + np.abs(self._contact_stiffness(w) * w.sum(-1)), rounding

    def hessian(self, u, w):
        """d2Pi/dw2, (n, 2, 2)."""
        cosine, sine, length, elongation, rotation, stiffness = self._chord(u, w)
        own = stiffness * (sine**2 + elongation * cosine**2 / length)
        own = own + self.rotational * (cosine**2 - 2.0 * rotation * sine * cosine) / length**2
        contact = self._contact_stiffness(w)
        return own[..., None] * np.eye(2) + contact[..., None, None]

    def follow(self, stretch, increment_count=INCREMENT_COUNT):
        """Minimum that continues the one at stretch 1: descent with |H| and halved steps, to round-off. (n, 2) [m]."""
        w = np.zeros_like(self.spacing)
        for k in range(1, increment_count + 1):
            u = (stretch - 1.0) * self.spacing * (k / increment_count)
            active = np.arange(len(w))
            for _ in range(200):
                here, u_here, w_here = self.part(active), u[active], w[active]
                gradient = here.gradient(u_here, w_here)[1]
                values, vectors = np.linalg.eigh(here.hessian(u_here, w_here))
                along = np.einsum("nji,nj->ni", vectors, gradient) / np.abs(values)
                step = -np.einsum("nij,nj->ni", vectors, along)
                size = np.hypot(here.spacing, here.height).min(-1)
                step *= np.minimum(1.0, 0.2 * size / np.maximum(np.linalg.norm(step, axis=-1), 1e-300))[:, None]
                unfinished = np.linalg.norm(step, axis=-1) > 1e-14 * size
                if not unfinished.any():
                    break
                before, share = here.energy(u_here, w_here), np.ones(len(active))
                for _ in range(40):
                    # equality passes: below round-off of the energy a step that shrinks the gradient is still good
                    higher = here.energy(u_here, w_here + share[:, None] * step) > before * (1.0 + 1e-13)
                    if not higher.any():
                        break
                    share[higher] *= 0.5
                w[active] = w_here + share[:, None] * step
                active = active[unfinished]
        return w
