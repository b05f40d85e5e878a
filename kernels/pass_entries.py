"""What the search for the contact of plies leaves: named as the rows in rows.py. This module does not import Warp."""

from .rows import Rows


class PassEntry(Rows):
    """What the search of one pass finds at every update of the stable step; one array of float64."""

    reach = "m", "how far both plies together may move until the next update"
    rebuild = "1", "1 if lists of candidates are made anew"
    stray_count = "1", "nodes that have found a foot at this update"
    late = "1", "1 if a node has ever left the facets on which it was listed: a contact may have been missed"
    deepest = "m", "deepest penetration so far that makes a force, at an update"
    watched = "1", "0 while every block of nodes sleeps, far from the facets"
    followed = "1", "1 if some node of it has a facet that it follows, or seeks one by itself"
    busy = "1", "0 where an update of contact within a sheet has nothing to do"
    quiet = "m", "of a sheet's first pass on itself: way up to which no groups can touch that hang together"
    apart = "m", "of the same: way up to which no other groups can touch"
    sought = "1", "of the same: 1 if groups that hang together are searched at this update, 2 if all are; else 0"
