"""The portable form: retroreflective lobes as nodes of the standard library, for hosts that know nothing else."""
