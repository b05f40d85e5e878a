"""Contact of sheets with tools between the nodes, as launched."""
