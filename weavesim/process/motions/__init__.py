"""Motions of tools beside those along an axis."""
