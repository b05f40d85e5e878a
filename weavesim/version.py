"""The version of weavesim, once."""

__version__ = "0.1.0"
