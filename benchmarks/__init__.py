"""Studies that stand behind the numbers in the docs; each runs with one command."""
