"""Form a blank on springs at its edges over a hemisphere, and release it; ``--help`` lists the options."""

from weavesim.app.command_line import main

if __name__ == "__main__":
    main("grippers")
