"""Samples of the distance to a mesh, as the kernels read them: grid, tiles, and triangles near doubted cells."""
