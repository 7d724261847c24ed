"""`python -m allanfit`, for where the command is not on the path."""

from .cli import run

if __name__ == "__main__":
    run()
