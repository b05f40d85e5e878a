"""What is wrong with a formed sheet: wrinkles, bridging, locking, gaps (docs/outputs.md)."""
