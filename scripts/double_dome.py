"""Form a woven blank over a double dome; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("double-dome")
