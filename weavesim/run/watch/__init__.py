"""What a run looks at of itself: its states, extremes, the condition of its sheets, distances from its tools."""
