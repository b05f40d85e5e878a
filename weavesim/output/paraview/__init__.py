"""The frames of a run for ParaView and PyVista."""
