"""Values that are missing a few at a time, as empty cells of a table are."""

from dataclasses import replace

import numpy as np
import pytest

import allanfit
from allanfit.explain import explain_recording
from allanfit.explain.values._closed_up import closed_up

RATE, SAMPLES = 50.0, 30_000


def test_a_line_is_seen_through_empty_cells():
    """Amplitude within five standard errors sqrt(2 S/T) of it, S = 2 N^2; N within five of .6 %."""
    rng, time = np.random.default_rng(3), np.arange(SAMPLES) / RATE
    values = 0.005 * RATE**0.5 * rng.standard_normal(SAMPLES)
    values += 0.004 * np.sin(2 * np.pi * 8.37 * time)
    values[rng.random(SAMPLES) < 0.005] = np.nan
    recording = allanfit.recording_of({"gyro_x": values}, rate_hz=RATE, unit="deg/s")
    (found,) = explain_recording(recording, posterior=False).to_dict()["channels"]
    (effect,) = found["effects"]
    assert effect["name"] == "sinusoid"
    assert effect["parameters"]["frequency"]["value"] == pytest.approx(
        8.37, abs=0.5 * RATE / SAMPLES
    )
    error = 2 * 0.005 * (RATE / SAMPLES) ** 0.5
    assert effect["parameters"]["amplitude"]["value"] == pytest.approx(0.004, abs=5 * error)
    assert found["coefficients_after"]["N"]["value"] == pytest.approx(0.005, rel=0.03)


def test_what_is_missing_is_lost_where_it_was():
    """Two at 200, one at 300 beside five that the clock lost, three before; a pause at 600."""
    values = np.random.default_rng(4).standard_normal((1000, 2))
    values[[200, 201, 300], 0] = np.nan
    values[600:700, 0] = np.nan
    columns = {"gyro_x": values[:, 0], "temperature": 25 + values[:, 1]}
    recording = allanfit.recording_of(columns, rate_hz=RATE, unit="deg/s")
    recording = replace(recording, losses=((100, 3), (301, 5)))
    channel, closed = closed_up(recording.channels[0], recording)
    assert closed.losses == ((100, 3), (200, 2), (298, 6))
    assert channel.stretches == ((0, 597), (697, 997))
    whole = np.delete(values, [200, 201, 300], axis=0)
    np.testing.assert_array_equal(channel.samples, np.deg2rad(whole[:, 0]))
    np.testing.assert_array_equal(closed.auxiliary[0].samples, 25 + whole[:, 1])


def test_a_whole_channel_stays_as_it_is():
    values = np.random.default_rng(5).standard_normal(1000)
    recording = allanfit.recording_of(values, rate_hz=RATE)
    channel, same = closed_up(recording.channels[0], recording)
    assert channel is recording.channels[0]
    assert same is recording
