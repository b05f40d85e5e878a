"""A formed part in the formats of other programs: what they read, and by which convention (docs/outputs.md)."""
