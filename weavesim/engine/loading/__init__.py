"""What pushes and pulls on the sheets, in the form that the kernels read."""
