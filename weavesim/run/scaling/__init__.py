"""How much faster a run may go for a stated error."""
