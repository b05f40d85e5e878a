"""Tables of measured values as laboratories write them: one reader for all of them, which refuses what it cannot read
in exactly one way."""

from .table import Columns, Table, Wanted, read_table

__all__ = ["Columns", "Table", "Wanted", "read_table"]
