"""Which runs a study asks for: designs, and an optimiser."""
