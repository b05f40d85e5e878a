"""How fast weavesim is: cases, what is measured of them, and the tables that say so."""
