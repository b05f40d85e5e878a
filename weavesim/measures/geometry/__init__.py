"""Triangles that meet, and bodies that may."""
