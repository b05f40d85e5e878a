"""Bit-by-bit comparison of two versions of weavesim: cases, running, reading, differences."""
