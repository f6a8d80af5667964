"""Studies and fleets on the workers of a cluster: the same numbers as in one process, whatever happens to a worker."""

import os
import signal
import time

import numpy as np
import pytest

import rivid

distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module", params=[1, 2])
def client(request):
    with (
        distributed.LocalCluster(n_workers=request.param, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def rows_of(results):
    return {(row.run, row.label): (row.status, row.value.tobytes(), row.sigma.tobytes()) for row in results.rows}


def test_a_study_has_the_rows_of_one_process(client, scara):
    from rivid import distributed as many

    told = []
    results = many.montecarlo(
        scara / "montecarlo_s1.toml", client=client, runs=7, runs_a_task=3, progress=lambda *at: told.append(at)
    )
    alone = rivid.montecarlo(scara / "montecarlo_s1.toml", runs=7)
    assert rows_of(results) == rows_of(alone)
    assert results.document == alone.document
    assert told[-1] == ("runs", 1.0)


def test_a_fleet_has_the_results_of_one_process(client, scara, tmp_path):
    pyarrow = pytest.importorskip("pyarrow.parquet")
    from rivid import distributed as many

    (tmp_path / "bad.toml").write_text("[robot]\nurdf = 'missing.urdf'\n[log]\nfiles = 'x.csv'\n")
    fleet = many.identify_fleet([scara / "scara.toml", tmp_path / "bad.toml", scara / "scara_iv.toml"], client=client)
    assert fleet.robots["status"] == ["identified", "error", "identified"]
    assert "missing.urdf" in fleet.robots[1]["why"]
    alone = rivid.identify(scara / "scara.toml")
    assert fleet.documents[scara / "scara.toml"]["parameters"] == alone.document["parameters"]
    fleet.to_parquet(tmp_path / "fleet.parquet")
    table = pyarrow.read_table(tmp_path / "fleet.parquet").to_pylist()
    assert len(table) == 2 * len(alone.chi)
    # Of two robots the median is half-way.
    first, second = (row for row in table if row["name"] == "ZZ2")
    assert first["from_median"] * first["sigma"] == pytest.approx(-second["from_median"] * second["sigma"])


def test_the_work_of_a_worker_that_dies_is_repeated(scara):
    from rivid import distributed as many

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        killed = []

        def kill_one(stage, fraction):
            if not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        results = many.montecarlo(scara / "montecarlo_s1.toml", client=client, runs=12, runs_a_task=1, progress=kill_one)
        while killed[0] in client.run(os.getpid).values():
            time.sleep(0.05)
    assert rows_of(results) == rows_of(rivid.montecarlo(scara / "montecarlo_s1.toml", runs=12))
    assert np.isfinite([row.seconds for row in results.rows]).all()
