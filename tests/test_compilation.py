"""Settings of XLA: one that a release does not know would end the process. What the cache keeps."""

import os

import jax
import jax.numpy as jnp
import pytest

from allanfit.compilation import (
    _flags,
    _forget_oldest,
    _options,
    on_the_cpu,
    platform,
    quick_to_compile,
)


@pytest.mark.parametrize(
    ("release", "known"), [("0.7.0", True), ("0.10.2", True), ("0.12.1", False)]
)
def test_flags_are_given_to_releases_that_know_them(release, known):
    flags = _flags(release).split()
    assert ("--xla_cpu_use_fusion_emitters=false" in flags) is known
    assert "--xla_backend_optimization_level=1" in flags


def test_a_setting_of_the_user_stays(monkeypatch):
    monkeypatch.setenv("XLA_FLAGS", "--xla_backend_optimization_level=3")
    assert "xla_backend_optimization_level" not in _options("cpu")
    monkeypatch.setenv("XLA_FLAGS", "--xla_force_host_platform_device_count=2")
    assert _options("cpu")["xla_backend_optimization_level"] == 1
    assert not _options("gpu")


def test_what_compiles_quickly_can_be_a_part_of_other_programs():
    # JAX refuses options of a program within a program.
    cube = quick_to_compile(jax.jit)(lambda x: x**3)
    assert cube(2.0) == 8.0
    assert jax.jit(lambda x: 2 * cube(x))(2.0) == 16.0
    assert jax.grad(cube)(2.0) == 12.0
    assert jax.vmap(cube)(jnp.arange(3.0)).tolist() == [0.0, 1.0, 8.0]


def test_small_programs_run_on_the_cpu_beside_an_accelerator(monkeypatch):
    assert platform() == "cpu"
    monkeypatch.setattr(jax, "default_backend", lambda: "gpu")
    with on_the_cpu():
        assert platform() == "cpu"
    assert platform() == "gpu"

    def none(backend):
        raise RuntimeError(f"Unknown backend {backend}")

    monkeypatch.setattr(jax, "local_devices", none)
    with on_the_cpu():
        assert platform() == "gpu"


def test_the_oldest_programs_go_though_another_process_removes_some(tmp_path, monkeypatch):
    monkeypatch.setattr("allanfit.compilation._MOST_BYTES", 25)
    for age, name in enumerate(("newest", "newer", "older", "oldest")):
        (tmp_path / name).write_bytes(b"0123456789")
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    # What is listed but has no status, as a file that is gone by the time it is asked for.
    (tmp_path / "gone").symlink_to(tmp_path / "nowhere")
    _forget_oldest(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gone", "newer", "newest"]
