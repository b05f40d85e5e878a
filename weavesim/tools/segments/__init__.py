"""Tools cut into sectors, each of which moves on its own."""
