"""Checkpoints: what a run needs to go on after its process was killed, in a folder of its own."""
