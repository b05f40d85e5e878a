"""One writer per file; see ``weavesim.output.writer``."""
