"""A first job for a tool of one's own: what its surface tells, and the text of the file."""
