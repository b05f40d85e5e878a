"""Pull a woven fabric in its bias direction; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("bias-extension")
