"""The Allan curve beside the spectrum: what both together know that the spectrum does not."""

import jax.numpy as jnp
import numpy as np
import pytest

from allanfit.curves import design, joint_covariance
from allanfit.identify._likelihood import fisher_information
from allanfit.physics import standard_model


@pytest.mark.parametrize(
    "coefficients",
    [{"N": 1.0, "B": 0.3, "K": 0.02}, {"Q": 0.5, "N": 1.0, "B": 0.1, "K": 0.1}],
)
def test_generalised_least_squares_on_both_curves_is_the_fit_of_the_spectrum(coefficients):
    """Information of both curves with their full covariance, over that of the spectrum alone.

    The Allan variance is a linear map of the spectrum's ordinates plus end terms without
    expectation, so that the ratio of standard deviations must be one. It is not exactly so because
    bins lump ordinates. Were the two curves added as if independent, it would be 0.7.
    """
    layout = design((2048,))
    power = np.array([coefficients.get(symbol, 0.0) for symbol in "QNBK"]) ** 2
    covariance = np.asarray(joint_covariance(standard_model(coefficients), layout).matrix())
    # The spectrum is blind to a ramp; the Allan curve is not, so that there R is a fifth unknown.
    blind = np.zeros((len(layout.density), 1))
    expected = np.concatenate([layout.allan, np.hstack([layout.density, blind])])
    deviation = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(deviation, deviation))
    # Directions whose variance is rounding or the 3 % accuracy of the covariance know nothing.
    kept = values > 0.01
    whitened = vectors[:, kept].T @ (expected / deviation[:, None]) / np.sqrt(values[kept])[:, None]
    spectrum = fisher_information(
        jnp.asarray(power), jnp.asarray(layout.density), jnp.asarray(layout.ordinates / 2)
    )
    present = power > 0
    with_ramp = np.append(present, True)
    joint = np.linalg.inv((whitened.T @ whitened)[np.ix_(with_ramp, with_ramp)])[:-1, :-1]
    alone = np.linalg.inv(np.asarray(spectrum)[np.ix_(present, present)])
    ratio = np.sqrt(np.diag(joint) / np.diag(alone))
    np.testing.assert_allclose(ratio, 1.0, atol=0.06)
