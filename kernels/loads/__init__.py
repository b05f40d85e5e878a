"""What pushes and pulls on a sheet from outside, added to the forces of its elements."""
