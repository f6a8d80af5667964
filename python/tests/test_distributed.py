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


@pytest.fixture(scope="module")
def logs(scara, tmp_path_factory):
    """Logs of one motion with nine noises."""
    folder = tmp_path_factory.mktemp("logs")
    out = []
    for seed in range(9):
        simulation = rivid.simulate(rivid.Experiment(scara / "simulate_s2.toml", {"simulation.seed": seed}, simulation=True))
        out.append(folder / f"run_{seed}.csv")
        simulation.log.to_csv(out[-1])
    return out


METHOD = rivid.Wls(decimation=20, torque_held=True)


def bits(fit):
    return fit.chi.tobytes(), fit.covariance.tobytes()


def test_many_logs_have_the_estimate_of_one_process(client, robot, logs):
    from rivid import distributed as many

    told = []
    fit = many.identify(robot, logs, METHOD, client=client, validation=logs[0], progress=lambda *at: told.append(at))
    together = rivid.identify(robot, logs, METHOD)
    assert fit.identified and told[-1] == ("logs", 1.0)
    # A least-squares solution: 10 ε κ ‖χ‖.
    rounding = 10 * np.finfo(float).eps * fit.document["fit"]["condition"] * np.linalg.norm(together.chi)
    assert np.linalg.norm(fit.chi - together.chi) <= rounding
    assert fit.document["fit"]["rows"] == together.document["fit"]["rows"]
    assert len(fit.document["provenance"]["inputs"]) == len(logs) + 1  # the URDF
    assert len(fit.document["validation"]) == 1
    at_once = many.identify(robot, logs, METHOD, client=client, logs_a_task=len(logs))
    assert at_once.chi.tobytes() == together.chi.tobytes()
    # Other estimates of the same deviations.
    assert np.median(np.array(fit.sigma) / np.array(together.sigma)) == pytest.approx(1.0, abs=0.4)
    # The tree is that of the logs: the workers change nothing.
    assert bits(fit) == bits(many.identify(robot, logs, METHOD, client=client))
    RESULTS.append(bits(fit))
    assert len(set(RESULTS)) == 1


RESULTS = []


IV = rivid.Iv(control=rivid.Pd(omega_n=[1, 10], zeta=1, rate_hz=200), decimation=20, torque_held=True)


def test_instrumental_variables_iterate_over_logs_that_are_elsewhere(client, robot, logs):
    from rivid import distributed as many

    told = []
    fit = many.identify(robot, logs, IV, client=client, progress=lambda *at: told.append(at[0]))
    together = rivid.identify(robot, logs, IV)
    assert fit.identified and together.identified
    # Rows are summed in another order; the iteration takes the same way.
    assert np.max(np.abs(fit.chi - together.chi) / together.sigma) < 1e-7
    assert len(fit.document["iterations"]) == len(together.document["iterations"])
    # The speeds, then inertias and rows of each iteration.
    assert told.count("loops") == 1 + 2 * len(fit.document["iterations"])
    assert fit.document["covariance"]["blocks"] == len(logs)
    RESULTS_OF_IV.append(bits(fit))
    assert len(set(RESULTS_OF_IV)) == 1


RESULTS_OF_IV = []


def test_the_rows_of_many_logs_are_chosen_by_the_first(client, robot, logs):
    from rivid import distributed as many

    fit = many.identify(robot, logs[:3], client=client)
    first = rivid.identify(robot, logs[0])
    assert fit.identified and first.identified
    assert "factors" in str(fit.document["method_choice"]) or "factors" in str(fit.notes)
    assert len(fit.predict(logs[0]).t) == len(first.predict(logs[0]).t)


def test_what_many_logs_can_not_be_used_for_is_said(client, robot, logs, tmp_path):
    from rivid import distributed as many

    with pytest.raises(rivid.InputError, match="robust"):
        many.identify(robot, logs[:2], rivid.Wls(decimation=20, robust="huber"), client=client)
    with pytest.raises(rivid.InputError, match="DIDIM"):
        many.identify(robot, logs[:2], rivid.Didim(control=rivid.Pd(omega_n=[1, 10], zeta=1), decimation=20), client=client)
    with pytest.raises(rivid.InputError, match="twice"):
        many.identify(robot, [logs[0], logs[1], logs[0]], METHOD, client=client)
    (tmp_path / "bad.csv").write_text("t,q1,q2\n0,1\n")
    with pytest.raises(rivid.InputError, match="bad.csv"):
        many.identify(robot, [logs[0], tmp_path / "bad.csv"], METHOD, client=client)
    with pytest.raises(rivid.InputError, match="no log"):
        many.identify(robot, [], METHOD, client=client)


def test_a_worker_that_dies_changes_nothing_of_an_identification(robot, logs):
    from rivid import distributed as many

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        undisturbed = many.identify(robot, logs, METHOD, client=client)
        killed = []

        def kill_one(stage, fraction):
            if fraction > 0.5 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        fit = many.identify(robot, logs, METHOD, client=client, progress=kill_one)
        assert killed
    assert bits(fit) == bits(undisturbed)


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
