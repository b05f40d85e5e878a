"""The contestants."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Peer:
    """One of Newton's solvers: steps per sixtieth of a second (None: from stability) and iterations per step."""

    solver: str
    steps_per_frame: int | None
    iterations: int | None


PEERS = {
    "Newton VBD": Peer("SolverVBD", 10, 10),
    "Newton VBD, 5 times the iterations": Peer("SolverVBD", 10, 50),
    "Newton Style3D": Peer("SolverStyle3D", 10, 4),
    "Newton XPBD": Peer("SolverXPBD", 10, 10),
    "Newton XPBD, explicit step": Peer("SolverXPBD", None, 2),
    "Newton SemiImplicit": Peer("SolverSemiImplicit", None, None),
}
OURS = {"weavesim float32": "float32", "weavesim float64": "float64"}
CONTESTANTS = (*OURS, *PEERS)


def isotropic(contestant: str) -> bool:
    """Whether its triangles are isotropic, without yarn directions."""
    return contestant in PEERS and PEERS[contestant].solver in ("SolverVBD", "SolverSemiImplicit")
