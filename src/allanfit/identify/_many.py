"""A batch of sensors: group after group over all devices, in bounded memory."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.core import Tracer
from jaxtyping import Array, Float, Int

from ..curves import (
    Design,
    Statistics,
    as_series,
    design,
    ends_matter,
    even_ends,
    statistics,
)
from ..physics import Sampling
from ._estimate import Estimate, as_design_dtype, conclude, estimate, prepare
from ._fit import PASSES, Fit, check_lengths, errors_and_white_noise, with_allan
from ._posterior import Target
from ._ramp import RampData

# Enough that the sampler's small operations are worth their calls; more only costs memory.
_SENSORS_AT_A_TIME = 16


def fit_many(
    data: Float[Array, "sensors samples"] | np.ndarray | Sequence,
    rate_hz: float,
    *,
    sampling: Sampling = "point",
    seed: int = 0,
) -> Fit:
    """Identify a batch of sensors with records of one length, shape (sensors, samples).

    Each sensor stands alone: one that holds NaN or is constant has `converged` false and NaN for
    its coefficients, and leaves the others' numbers as they are.

    Wide codes of an angle are not looked for: see `allanfit.fit`.

    Sensors are taken in groups, shared out among all devices of the kind that holds the data, or
    among the cores of a processor. A NumPy array stays where it is, and only the groups at work
    are copied, so that `numpy.memmap` serves batches larger than memory; beside it there must be
    room for the results, 130 kB a sensor in float64.

    **Arguments:**

    - `data`: samples, in any unit u, shape (sensors, samples), at least 256 samples.
    - `rate_hz`, `sampling`: as for `allanfit.fit`, the same for all sensors.
    - `seed`: of the posterior's draws; the same seed gives the same numbers, on any number of
      devices.

    **Returns:** a `Fit` whose arrays have a leading axis of sensors; `converged` says of each
    whether its numbers mean anything.

    **Raises:** `ValueError` for a wrong shape, too few samples or a rate that is not positive.
    """
    if not isinstance(data, jax.Array | np.ndarray):
        data = np.asarray(data)
    if data.ndim != 2 or not len(data):
        raise ValueError(f"data must have shape (sensors, samples); got {data.shape}")
    check_lengths(data.shape[1:])
    first = as_series(data[:1], rate_hz)
    layout = design(data.shape[1:], sampling)
    if isinstance(data, Tracer) or isinstance(rate_hz, Tracer):
        keys = _keys(jax.random.key(seed), jnp.arange(len(data)))
        series = as_series(data, rate_hz)
        found = jax.vmap(estimate, (0, None, None, 0))((series,), layout, 1 / rate_hz, keys)
        return Fit(found, layout, rate_hz)

    (platform,) = {device.platform for device in first.devices()}
    devices = jax.local_devices(backend=platform)
    layouts = [jax.device_put(as_design_dtype(layout, first.dtype), device) for device in devices]
    wide = jax.config.jax_enable_x64  # pyright: ignore[reportAttributeAccessIssue]

    def one_group(
        place: int, group: Int[np.ndarray, " group"], rows: np.ndarray | None = None
    ) -> Estimate:
        device = devices[place % len(devices)]
        # Settings that a caller makes for a while are those of his thread alone.
        with jax.enable_x64(wide), jax.default_device(device):
            series = jax.device_put(
                as_series(data[group] if rows is None else rows, rate_hz), device
            )
            found, *rest = _reduce_group(series, layouts[place % len(devices)])
            dt = jnp.asarray(1 / rate_hz, series.dtype)
            concluded = _conclude_group(*rest, dt, jax.random.key(seed), jnp.asarray(group))
            return jax.device_get(_together(found, concluded))

    # Several programs at once keep the cores busy, which one program of small operations does not.
    workers = max(os.cpu_count() or 1, len(devices)) if platform == "cpu" else len(devices)
    gathered = partial(_gathered, warm_up=len(devices), workers=workers)
    whole = gathered(one_group, len(data))
    for _ in range(PASSES):
        error, white = errors_and_white_noise(whole, rate_hz)
        ruled = np.flatnonzero(ends_matter(data.shape[1], error, white))
        if not ruled.size:
            break

        def between_even_ends(
            place: int, group: Int[np.ndarray, " group"], of=ruled, error=error, white=white
        ) -> Estimate:
            # What is added to the ends is no whole number, and finer than single precision.
            rows = [even_ends(np.asarray(data[i], float), error[i], white[i]) for i in of[group]]
            return one_group(place, of[group], np.stack(rows))

        again = gathered(between_even_ends, ruled.size)
        # The curve that people see stays that of the record.
        again = with_allan(again, whole.statistics.allan[ruled])
        whole = jax.tree.map(lambda old, new, at=ruled: old.at[at].set(new), whole, again)
    return Fit(whole, layout, rate_hz)


def _gathered(
    one_group: Callable[[int, Int[np.ndarray, " group"]], Estimate],
    sensors: int,
    *,
    warm_up: int,
    workers: int,
) -> Estimate:
    """The estimates of all sensors, each group written where it belongs as soon as it is there.

    The first `warm_up` groups go ahead, lest workers compile the same program side by side.
    """
    starts = range(0, sensors, _SENSORS_AT_A_TIME)
    whole: list[np.ndarray] = []

    def work(place: int) -> tuple[int, Estimate]:
        # The last group is filled up with the last sensor: one compilation serves any number.
        group = np.minimum(starts[place] + np.arange(_SENSORS_AT_A_TIME), sensors - 1)
        return starts[place], one_group(place, group)

    pool = ThreadPoolExecutor(workers)
    try:
        for places in (range(len(starts))[:warm_up], range(len(starts))[warm_up:]):
            for start, found in pool.map(work, places):
                parts, structure = jax.tree.flatten(found)
                if not whole:
                    whole = [np.empty((sensors, *part.shape[1:]), part.dtype) for part in parts]
                for all_sensors, part in zip(whole, parts, strict=True):
                    rows = all_sensors[start : start + _SENSORS_AT_A_TIME]
                    rows[:] = part[: len(rows)]
    finally:
        # An interrupt or an error is not to wait for groups that have not begun.
        pool.shutdown(cancel_futures=True)
    return jax.tree.unflatten(structure, [jnp.asarray(each) for each in whole])


@jax.vmap
def _together(found: Statistics, concluded: dict[str, Array]) -> Estimate:
    return Estimate(statistics=found, **concluded)


def _keys(key: Array, numbers: Int[Array, " sensors"]) -> Array:
    return jax.vmap(jax.random.fold_in, (None, 0))(key, numbers)


@eqx.filter_jit
def _reduce_group(
    series: Float[Array, "sensors samples"], layout: Design
) -> tuple[Statistics, Target, RampData]:
    def single(x: Float[Array, " samples"]) -> tuple[Statistics, Target, RampData]:
        found = statistics((x,), layout)
        return found, *prepare(found, layout)

    # A processor is fastest when it has one series in its cache.
    return jax.lax.platform_dependent(
        series, cpu=partial(jax.lax.map, single), default=jax.vmap(single)
    )


@jax.jit
def _conclude_group(
    data: Target, ramp: RampData, dt: Float[Array, ""], key: Array, numbers: Int[Array, " sensors"]
) -> dict[str, Array]:
    return jax.vmap(conclude, (0, 0, None, 0))(data, ramp, dt, _keys(key, numbers))
