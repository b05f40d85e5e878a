"""One writer of results per file; see ``weavesim.output.writer``."""
