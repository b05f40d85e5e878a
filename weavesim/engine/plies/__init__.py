"""Contact between the plies of a stack: constants, state and launches of every pass of every interface."""
