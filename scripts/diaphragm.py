"""Draw plies between two rubber diaphragms over a dome, by vacuum; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("diaphragm")
