"""Surfaces of tools made from the surface of another: offset, and the rim around an opening."""
