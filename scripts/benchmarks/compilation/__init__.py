"""How long a user waits for the compiler."""
