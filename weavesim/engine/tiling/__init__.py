"""How the work of a step is divided, and where its tiles keep what they hand over."""
