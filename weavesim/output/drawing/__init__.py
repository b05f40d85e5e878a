"""Figures become files: the places of everything in them, and PNG."""
