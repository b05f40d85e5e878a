"""Pull a strip of woven fabric along one yarn; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("uniaxial")
