"""``results.h5``: the final state of a run, written for programs, and read back by the commands that go on from it."""
