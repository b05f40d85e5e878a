"""How fast weavesim is: cases, measurements and tables."""
