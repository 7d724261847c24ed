"""Lines and narrow bands: found, told from resonances, and followed as they move."""
