"""Two versions of weavesim compared bit by bit: what is run, how, what is read of it, and what differs."""
