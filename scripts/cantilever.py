"""Let a strip of woven fabric hang over an edge; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("cantilever")
