"""Run every benchmark in its quick form: `python -m benchmarks`."""

from . import truth

if __name__ == "__main__":
    truth.main(["--quick"])
