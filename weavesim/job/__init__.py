"""Jobs: a forming run as a file, without a line of Python."""
