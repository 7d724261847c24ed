"""Two recordings, and a cluster in this process, whose compiled programs the tests share."""

import distributed
import pytest
from fleet_recordings import write_recording

from allanfit.fleet import _task


@pytest.fixture
def recordings(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    return [write_recording(folder / f"unit_{k}.npz", seed=k) for k in (1, 2)]


@pytest.fixture(scope="session")
def scheduler():
    """The address of a scheduler with a worker in this process, which is configured already."""
    with (
        pytest.MonkeyPatch.context() as patch,
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
    ):
        patch.setattr(_task, "configure_program", lambda: None)
        yield cluster.scheduler_address
