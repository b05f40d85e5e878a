"""Tools of a job that are cut into sectors."""
