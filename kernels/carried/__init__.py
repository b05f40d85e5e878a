"""Tools that are carried along a path and turned, beside their motion along an axis."""
