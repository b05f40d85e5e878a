"""What is kept of two creases that may touch: named as the rows in rows.py. This module does not import Warp."""

from ..rows import Rows


class PairRow(Rows):
    """One entry of the list of an edge: another edge that may touch it. Both edges keep the same numbers."""

    weight = "1", "share of the stiffness at which the pair acts, 0 to 1"
    press = "m", "penetration that makes a force"
    entry = "m", "penetration at which the contact began, as far as it has not been given back: it makes no force"
    depth = "m", "penetration, with the entry; negative where they do not touch"
    first = "1", "where the contact is on the edge of the lower number, from 0 to 1"
    second = "1", "the same of the other edge"
    step = "s", "mean step over which the force of the last step acted"
    spring = "m", "tangential spring", 3
    dashpot = "N", "force of the dashpot on the edge of the lower number", 3


class CreaseWorkRow(Rows):
    """Works at an edge and those of higher numbers, as ``PlyWorkRow``; in float64."""

    friction_work = "J", "work done against friction, lost or held in the friction springs"
    damping_loss = "J", "energy lost in dashpots, and of springs that are released where an edge ends"
    thickness_work = "J", "work of the change of the weights"


class CreaseCount(Rows):
    """Numbers of a list of creases; one array of int32."""

    creases = "1", "edges with a weight"
    pairs = "1", "entries of all lists"
    late = "1", "1 if there was ever no room for all entries: a contact may have been missed"
