"""The version of weavesim."""

__version__ = "0.1.0"
