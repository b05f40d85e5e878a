"""Form a stack of plies that slip on each other; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("stack")
