"""Let a square cloth fall on a hemisphere; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("hemisphere")
