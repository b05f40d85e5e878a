"""What the runs of a study say: noise, sensitivity, the best."""
