"""The stages of a job: their tables, what is made of them, and how they are told."""
