"""Run the benchmarks in their quick forms: `python -m benchmarks`."""

from . import export, optima, plan, truth

if __name__ == "__main__":
    truth.main(["--quick"])
    optima.main(["--fits", "500"])
    plan.main(["--records", "40"])
    export.main()
