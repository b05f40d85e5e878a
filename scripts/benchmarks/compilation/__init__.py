"""How long a user waits for the first step: for the compiler, and for the start of the command."""
