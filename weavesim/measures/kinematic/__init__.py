"""The kinematic drape: a net of inextensible yarns, pinned where they cross, laid onto a tool (docs/outputs.md)."""
