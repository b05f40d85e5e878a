"""Site, gallery and notebooks of the documentation, made from ``docs/`` and the code."""
