"""Mass scaling by a stated error: what was tried and chosen."""
