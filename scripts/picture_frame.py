"""Shear a woven fabric in a picture frame; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("picture-frame")
