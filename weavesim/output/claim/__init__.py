"""A folder of results belongs to one run: its lock, its record, and what may be removed before the next run."""
