"""Results, resumption and errors, with a worker in this process."""

import hashlib
import subprocess
import sys

import distributed
import numpy as np
import pandas
import polars
import pyarrow.parquet
import pytest
from fleet_recordings import write_recording

import allanfit
from allanfit.fleet import FleetError, Options, _run, _task, run_fleet


def parts(output):
    """What tells whether a part was written again."""
    return {
        path.name: (path.stat().st_ino, path.stat().st_mtime_ns)
        for path in (output / "results").iterdir()
    }


def test_the_dataset_holds_what_fit_tells(recordings, tmp_path, scheduler):
    output = tmp_path / "fleet"
    run = run_fleet(recordings, output, scheduler=scheduler)
    assert (run.analysed, run.unchanged, run.errors) == (2, 0, ())
    data = polars.read_parquet(output / "results" / "*.parquet").sort("recording")
    assert data["recording"].to_list() == ["unit_1.npz", "unit_2.npz"]
    assert len(pandas.read_parquet(output / "results")) == 2
    assert pyarrow.parquet.read_table(output / "results").num_rows == 2
    row = data.row(0, named=True)
    loaded = allanfit.load(recordings[0])
    (channel,) = loaded.channels
    fit = allanfit.fit(channel.samples, loaded.rate_hz)
    for symbol, value in fit.coefficients.items():
        resolved = bool(fit.resolved[symbol])
        limit = None if resolved else float(fit.upper_limits[symbol]) / channel.factor
        assert row[symbol] == pytest.approx(float(value) / channel.factor, rel=1e-6)
        assert row[f"{symbol}_resolved"] == resolved
        assert row[f"{symbol}_upper_limit_95"] == (limit and pytest.approx(limit, rel=1e-6))
        ends = [row[f"{symbol}_low_95"], row[f"{symbol}_high_95"]]
        assert ends == pytest.approx(np.asarray(fit.intervals[symbol]) / channel.factor, rel=1e-6)
    assert row["N_unit"] == "deg/s/sqrt(Hz)"
    # The truth of the samples: white noise of variance 1 at 50 Hz.
    assert row["N_low_95"] < 50**-0.5 < row["N_high_95"]
    assert (row["unit"], row["rate_hz"], row["samples"]) == ("deg/s", 50.0, 2048)
    assert row["checksum"] == loaded.checksum
    assert row["file_sha256"] == hashlib.sha256(recordings[0].read_bytes()).hexdigest()
    assert (row["allanfit_version"], row["status"]) == (allanfit.__version__, "converged")
    assert row["p_value"] == pytest.approx(float(fit.goodness_of_fit), rel=1e-6)


def test_that_no_worker_is_there_is_said_once_and_waited_out(recordings, tmp_path, monkeypatch):
    monkeypatch.setattr(_run, "_PATIENCE_S", 0.2)
    monkeypatch.setattr(_task, "configure_program", lambda: None)
    told = []
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:

        def waiting(sentence):
            told.append(sentence)
            # Once more as long, in which it is not said again.
            cluster.loop.call_later(0.5, cluster.scale, 1)

        output = tmp_path / "fleet"
        run = run_fleet(
            recordings[:1], output, scheduler=cluster.scheduler_address, waiting=waiting
        )
    assert run.analysed == 1
    (sentence,) = told
    assert sentence.startswith("The scheduler has no worker: start one with `dask worker`")


def test_only_what_changed_is_done_again(recordings, tmp_path, scheduler):
    output = tmp_path / "fleet"
    run_fleet(recordings, output, scheduler=scheduler)
    before = parts(output)
    again = run_fleet(recordings, output, scheduler=scheduler)
    assert (again.analysed, again.unchanged, len(again.rows)) == (0, 2, 2)
    assert parts(output) == before
    write_recording(recordings[0], seed=9)
    changed = run_fleet(recordings, output, scheduler=scheduler)
    assert (changed.analysed, changed.unchanged) == (1, 1)
    assert len({*parts(output).items()} - {*before.items()}) == 1
    other = run_fleet(recordings, output, Options(sampling="averaged"), scheduler=scheduler)
    assert (other.analysed, other.unchanged, len(parts(output))) == (2, 0, 2)


def test_results_of_another_version_and_damaged_ones_are_made_again(
    recordings, tmp_path, scheduler, monkeypatch
):
    output = tmp_path / "fleet"
    run_fleet(recordings, output, scheduler=scheduler)
    part = sorted((output / "results").iterdir())[0]
    part.write_bytes(part.read_bytes()[:500])
    run = run_fleet(recordings, output, scheduler=scheduler)
    assert (run.analysed, run.unchanged, len(run.rows)) == (1, 1, 2)
    for module in ("_run", "_task"):
        monkeypatch.setattr(f"allanfit.fleet.{module}.version", lambda package: "99.0")
    assert run_fleet(recordings, output, scheduler=scheduler).analysed == 2


def test_a_bad_recording_is_a_row_and_the_others_go_on(recordings, tmp_path, scheduler):
    damaged = recordings[0].with_name("damaged.npz")
    damaged.write_bytes(b"PK\x03\x04 no more")
    files = [*recordings, damaged, tmp_path / "vanished.npz"]
    output = tmp_path / "fleet"
    run = run_fleet(files, output, scheduler=scheduler)
    errors = {path.name: error for path, error in run.errors}
    assert "complete .npz file" in errors["damaged.npz"]
    assert "no file" in errors["vanished.npz"]
    assert "on the worker" in errors["vanished.npz"]
    assert len(polars.read_parquet(output / "results" / "*.parquet")) == 4
    # A damaged file stays damaged; one that is not there may come.
    write_recording(tmp_path / "vanished.npz", seed=3)
    again = run_fleet(files, output, scheduler=scheduler)
    assert (again.analysed, again.unchanged, len(again.errors)) == (1, 3, 1)


def test_a_result_outlives_its_recording(recordings, tmp_path, scheduler):
    output = tmp_path / "fleet"
    run_fleet(recordings, output, scheduler=scheduler)
    before = parts(output)
    recordings[0].unlink()
    run = run_fleet(recordings, output, scheduler=scheduler)
    assert [path for path, _ in run.kept] == [recordings[0]]
    assert parts(output) == before
    assert not run.errors


def test_one_name_in_two_folders_and_one_file_twice(recordings, tmp_path, scheduler):
    twin = tmp_path / "other" / recordings[0].name
    twin.parent.mkdir()
    write_recording(twin, seed=4)
    link = tmp_path / "link.npz"
    link.symlink_to(recordings[0])
    files = [recordings[0], twin, recordings[0], link]
    run = run_fleet(files, tmp_path / "fleet", scheduler=scheduler)
    assert [row["path"] for row in run.rows] == [str(recordings[0]), str(twin)]


def test_a_part_half_written_is_met_by_no_reader(recordings, tmp_path, scheduler):
    output = tmp_path / "fleet"
    output.mkdir()
    (output / ".unit_1.npz-0123.parquet.999.part").write_bytes(b"PAR1 half")
    run_fleet(recordings, output, scheduler=scheduler)
    assert len(polars.read_parquet(output / "results" / "*.parquet")) == 2


def test_a_folder_that_cannot_be_written_is_said_first(recordings, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_bytes(b"")
    with pytest.raises(FleetError, match=r"Cannot write results to .*file.*writable"):
        run_fleet(recordings, blocked)


def test_a_disk_that_fills_keeps_what_is_done(recordings, tmp_path, scheduler, monkeypatch):
    output = tmp_path / "fleet"
    written = []

    def write_table(table, stream):
        if written:
            raise OSError(28, "No space left on device")
        written.append(True)
        original(table, stream)

    original = pyarrow.parquet.write_table
    monkeypatch.setattr(pyarrow.parquet, "write_table", write_table)
    with pytest.raises(FleetError, match=r"No space left.*what is done stays done"):
        run_fleet(recordings, output, scheduler=scheduler)
    monkeypatch.undo()
    run = run_fleet(recordings, output, scheduler=scheduler)
    assert (run.analysed, run.unchanged) == (1, 1)
    assert [path.name for path in output.iterdir()] == ["results"]


def test_no_scheduler_is_one_sentence(recordings, tmp_path, monkeypatch):
    monkeypatch.setattr("allanfit.fleet._cluster._PATIENCE_S", 0.5)
    with pytest.raises(FleetError, match=r"No scheduler answers at tcp://127\.0\.0\.1:9"):
        run_fleet(recordings, tmp_path / "fleet", scheduler="tcp://127.0.0.1:9")
    with pytest.raises(FleetError, match="leave out --workers"):
        run_fleet(recordings, tmp_path / "fleet", scheduler="tcp://127.0.0.1:9", workers=2)


@pytest.mark.parametrize("address", ["nonsense", "", "tcp://two words:1", "tcp://host"])
def test_what_is_no_address_is_said_at_once(recordings, tmp_path, address):
    with pytest.raises(FleetError, match="is no address of a scheduler"):
        run_fleet(recordings, tmp_path / "fleet", scheduler=address)


def test_an_array_in_the_folder_of_one_device_is_one_device(tmp_path, scheduler):
    """Replicates in one recording are devices of their own."""
    rng = np.random.default_rng(8)
    path = write_recording(
        tmp_path / "bench.npz",
        seed=1,
        **{f"accel_z_{k:02d}": rng.standard_normal(2048) for k in (1, 2)},
    )
    run = run_fleet([path], tmp_path / "fleet", scheduler=scheduler)
    assert [(row["quantity"], row["device"]) for row in run.rows] == [
        ("gyro_x", "bench"),
        ("accel_z", "bench/01"),
        ("accel_z", "bench/02"),
    ]


def test_a_script_that_each_worker_would_run_is_told_so(recordings, tmp_path):
    script, output = tmp_path / "script.py", tmp_path / "fleet"
    script.write_text(
        "from allanfit.fleet import run_fleet\n"
        f"run_fleet([{str(recordings[0])!r}], {str(output)!r}, workers=1)\n"
    )
    told = subprocess.run([sys.executable, str(script)], capture_output=True, text=True)
    assert told.returncode == 1
    assert told.stderr.endswith("below a line `if __name__ == '__main__':`.\n")
