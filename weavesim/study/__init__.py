"""Studies: many runs of one job, to compare, to know the scatter, to find what matters and what is best."""
