"""The page of a run, ``report.html``: a viewer of all frames and every number, in one file that needs no network."""
