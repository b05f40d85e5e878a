"""Stages of a run: what acts in each, whether they can be, and the set-up of one alone."""
