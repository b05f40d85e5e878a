"""Commands that go on from the results of a run. Each is a module of this folder."""
