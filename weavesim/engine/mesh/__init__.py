"""The mesh of a sheet in the form that the kernels read."""
