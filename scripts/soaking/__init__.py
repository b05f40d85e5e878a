"""Parts of the soak, each a function that prints its progress and returns whether all was well."""
