"""A recording against a simulation, and which of the two lacks what."""
