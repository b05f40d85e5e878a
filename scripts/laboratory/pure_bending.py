"""Bend a strip of woven fabric both ways by a moment; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("pure-bending")
