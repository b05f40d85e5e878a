"""Where the runs of a study are computed: this process, processes of this machine, a cluster."""
