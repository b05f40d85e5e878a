"""Many worlds that never meet, stepped in one launch."""
