"""Let a round specimen of woven fabric hang over a disc; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("cusick-drape")
