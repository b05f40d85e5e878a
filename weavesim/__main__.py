"""``python -m weavesim``."""

from .command_line import main

main()
