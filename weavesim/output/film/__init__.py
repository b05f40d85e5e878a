"""The film of a run in USD: written while it runs, read back, and drawn as a movie."""
