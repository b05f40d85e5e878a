"""How often a run writes a checkpoint."""

from __future__ import annotations

# Wall time between two checkpoints [s], and the largest share of it that they may take.
INTERVAL = 600.0
LARGEST_SHARE = 0.02
