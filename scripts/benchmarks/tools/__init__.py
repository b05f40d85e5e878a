"""Costs of tools."""
