"""A Dask cluster of two worker processes on loopback comes to the same as this process, to the byte in STEP."""

from __future__ import annotations

import pytest
from variants import SAMPLES, assert_same, lengths

pytest.importorskip("OCP", reason="solids need the kernel")
pytest.importorskip("distributed", reason="the extra dask")

from cablecad.batch import run_batch, table_rows

# What distributed does as it closes is not ours to mend.
pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(scope="module")
def cluster():
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=None
    ) as made:
        yield made


def test_dask_makes_no_difference(cluster, tmp_path, cli, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")  # which the workers do not have
    scene = SAMPLES / "clamped.toml"
    table = lengths(tmp_path / "table.csv", [300, 100, 350])
    run_batch(table_rows(table, scene), folder=tmp_path / "here", workers=0)
    ended = cli("batch", table, "--scene", scene, "-o", tmp_path / "dask", "--dask", cluster.scheduler_address)
    assert ended.code == 6
    assert_same(tmp_path / "here", tmp_path / "dask")


def test_executor_of_a_client(cluster, tmp_path):
    scene = SAMPLES / "clamped.toml"
    table = table_rows(lengths(tmp_path / "table.csv", [300, 310]), scene)
    run_batch(table, folder=tmp_path / "here", output="none", workers=0)
    from distributed import Client

    with Client(cluster, set_as_default=False) as client:
        run_batch(table, folder=tmp_path / "dask", output="none", executor=client.get_executor())
    assert_same(tmp_path / "here", tmp_path / "dask")


def test_a_scheduler_that_does_not_answer(tmp_path, cli, monkeypatch):
    monkeypatch.setattr("cablecad.cli.batch._DASK_WAIT", "1s")
    table = lengths(tmp_path / "table.csv", [300])
    ended = cli("batch", table, "--scene", SAMPLES / "clamped.toml", "-o", tmp_path / "out", "--dask", "127.0.0.1:9")
    assert ended.code == 5
    assert "no Dask scheduler answers at 127.0.0.1:9" in ended.err
    assert not (tmp_path / "out").exists()
