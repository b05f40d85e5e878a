"""Reads decks with the packages of others, which want an older NumPy: run by the Python of ``make readers``.

deck_readers.py nastran FILE    # pyNastran
deck_readers.py lsdyna FILE     # ansys-dyna-core

Prints JSON: for each element its corners and the fibre direction of each layer.
"""

import json
import sys

import numpy as np


def nastran(path: str) -> dict:
    """Material axes of the elements by pyNastran, turned by the angles of the layers."""
    from pyNastran.bdf.bdf import read_bdf

    model = read_bdf(path, debug=None)
    found = {}
    for number, element in model.elements.items():
        _, _, first, second, _ = element.material_coordinate_system()
        layers = element.pid_ref
        assert layers.type == "PCOMP"
        turns = np.radians(layers.get_thetas())
        found[number] = {
            "corners": np.array(element.get_node_positions()).tolist(),
            "fibres": [(np.cos(turn) * first + np.sin(turn) * second).tolist() for turn in turns],
            "thickness": float(sum(layers.get_thicknesses())),
        }
    return found


def lsdyna(path: str) -> dict:
    """Fields of the cards by ansys-dyna-core; B turns from the side N1 to N2 about the normal, since AOPT is 0."""
    from ansys.dyna.core import Deck
    from ansys.dyna.core.keywords import keywords

    with open(path, encoding="utf-8") as file:
        text = file.read()
    # that reader takes one element for each keyword
    head, name, rest = text.partition("*ELEMENT_SHELL_COMPOSITE\n")
    cards, star, end = rest.partition("*")
    deck = Deck()
    deck.loads(head + star + end)
    (node,) = deck.get_kwds_by_type("NODE")
    (material,) = deck.get_kwds_by_type("MAT")
    assert material.aopt == 0.0
    nodes = {int(row.nid): np.array([row.x, row.y, row.z]) for row in node.nodes.itertuples()}
    found, lines = {}, cards.splitlines()
    for k in range(0, len(lines), 2):
        one = keywords.ElementShellComposite()
        one.loads(name + "\n".join(lines[k : k + 2]) + "\n")
        corners = [nodes[number] for number in (one.n1, one.n2, one.n3, one.n4)]
        normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
        normal /= np.linalg.norm(normal)
        first = corners[1] - corners[0]
        first -= normal * (first @ normal)
        first /= np.linalg.norm(first)
        turns = np.radians([one.b1, one.b2])
        found[one.eid] = {
            "corners": np.array(corners).tolist(),
            "fibres": [(np.cos(t) * first + np.sin(t) * np.cross(normal, first)).tolist() for t in turns],
            "thickness": float(one.thick1 + one.thick2),
        }
    return found


if __name__ == "__main__":
    print(json.dumps({"nastran": nastran, "lsdyna": lsdyna}[sys.argv[1]](sys.argv[2])))
