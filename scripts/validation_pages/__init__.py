"""Pages of the validation, one module each: a function that runs what it shows and returns its text."""
