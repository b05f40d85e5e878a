"""Pull a woven fabric along both yarns; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("biaxial")
