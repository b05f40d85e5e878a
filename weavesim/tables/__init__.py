"""Tables of measured values as laboratories write them: one reader for all of them, which refuses what it cannot read
in exactly one way."""

from .repeats import Repeat, Repeats, Role, read_repeats
from .table import Columns, Table, Wanted, read_table

__all__ = ["Columns", "Repeat", "Repeats", "Role", "Table", "Wanted", "read_repeats", "read_table"]
