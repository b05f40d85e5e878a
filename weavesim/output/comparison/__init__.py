"""A formed sheet beside something else: a kinematic drape, another run, a measurement (docs/outputs.md)."""
