"""The blanks of a job: outlines from numbers and files, meshed."""
