"""What `simulate` refuses, and the seeds that it takes."""

import math

import numpy as np
import pytest

import allanfit


def simulate(coefficients, **options):
    return allanfit.simulate(
        coefficients, **{"duration_s": 10.0, "rate_hz": 10.0, "seed": 0, **options}
    )


@pytest.mark.parametrize(
    ("coefficients", "options", "message"),
    [
        ({"N": math.inf}, {}, "coefficient N must be zero or more, and finite; got inf"),
        ({"N": math.nan}, {}, "coefficient N must be zero or more, and finite; got nan"),
        ({"N": -1.0}, {}, "coefficient N must be zero or more, and finite; got -1.0"),
        ({"N": 1.0}, {"bias": math.nan}, "bias must be a finite number; got nan"),
        ({"N": 1.0}, {"bias": -math.inf}, "bias must be a finite number; got -inf"),
        ({"N": 1.0}, {"seed": 2**63}, r"seed must be below 2\^63; got 9223372036854775808"),
    ],
)
def test_what_is_no_number_is_refused(coefficients, options, message):
    with pytest.raises(ValueError, match=message):
        simulate(coefficients, **options)


def test_the_largest_seed_gives_samples():
    found = simulate({"N": 1.0}, seed=2**63 - 1)
    assert np.isfinite(found).all()
    assert not np.array_equal(found, simulate({"N": 1.0}, seed=2**63 - 2))
