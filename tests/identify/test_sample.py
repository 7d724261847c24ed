"""emcee's posterior: diagnostics, repeatability, and agreement with the one drawn in JAX."""

import os
import subprocess
import sys

import numpy as np
import pytest

import allanfit
from allanfit.identify import _sample
from allanfit.identify._diagnostics import effective_sample_size, r_hat


@pytest.fixture(scope="module")
def fitted():
    """Of the length and rate of test_fit, for one compilation."""
    coefficients = {"N": 5e-3, "B": 2e-3, "K": 1e-3}
    x = allanfit.simulate(coefficients, duration_s=819.2, rate_hz=10.0, seed=3)
    return allanfit.fit(x, 10.0)


def test_posterior_converges_and_agrees_with_the_fast_one(fitted):
    posterior = allanfit.sample(fitted, seed=1)
    assert posterior.converged
    assert max(posterior.r_hat.values()) < 1.05
    slow = fitted.with_draws(posterior.draws.reshape(-1, 5))
    for symbol in "NBK":
        width = float(np.diff(slow.intervals[symbol])[0])
        shift = np.abs(np.asarray(slow.intervals[symbol] - fitted.intervals[symbol])).max()
        assert shift < 0.15 * width, symbol


def test_the_same_seed_gives_the_same_draws(fitted, monkeypatch):
    monkeypatch.setattr(_sample, "_BURN_IN", 20)
    monkeypatch.setattr(_sample, "_ROUND", 100)
    one = allanfit.sample(fitted, seed=2, most_rounds=1)
    two = allanfit.sample(fitted, seed=2, most_rounds=1)
    other = allanfit.sample(fitted, seed=3, most_rounds=1)
    assert np.array_equal(one.draws, two.draws)
    assert not np.array_equal(one.draws, other.draws)


def test_diagnostics_see_a_chain_that_has_not_mixed():
    rng = np.random.default_rng(0)
    mixed = rng.normal(size=(8, 500))
    assert r_hat(mixed) < 1.01
    assert effective_sample_size(mixed) > 2000
    assert r_hat(mixed + np.arange(8)[:, None]) > 1.5


def test_diagnostics_need_no_home_and_announce_nothing(tmp_path):
    """In a process of its own, as arviz is loaded once."""
    home = tmp_path / "home"
    home.write_text("no folder")
    moved = ("XDG_CACHE_HOME", "XDG_CONFIG_HOME", "MPLCONFIGDIR")
    environment = {name: value for name, value in os.environ.items() if name not in moved}
    code = (
        "from allanfit.cli import main\n"
        "main(['--version'])\n"
        "import numpy as np\n"
        "from allanfit.identify._diagnostics import r_hat\n"
        "import platformdirs\n"
        "print(r_hat(np.random.default_rng(0).normal(size=(8, 500))) < 1.01)\n"
        "print(platformdirs.user_cache_dir('arviz'))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=environment | {"HOME": str(home)},
        check=False,
    )
    assert run.stderr == ""
    _, small, folder = run.stdout.splitlines()
    assert small == "True"
    # What others ask platformdirs for later is as it was.
    assert folder.startswith(str(home))
