"""A run in stages: where it is, when a stage ends, and what changes from one to the next."""
