"""Tools that are carried along a path and turned."""
