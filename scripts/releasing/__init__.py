"""Releases: the same bytes from the same commit, and an audit of what they depend on."""
