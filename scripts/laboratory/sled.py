"""Pull a weight with a woven fabric under it over a table; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("sled")
