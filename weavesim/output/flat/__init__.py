"""Flat patterns of formed parts: which part of a flat blank becomes the part."""
