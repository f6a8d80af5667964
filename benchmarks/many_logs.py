"""Many logs of the six-axis robot identified together by Dask: wall and CPU time with one and two workers, and bytes.

    python benchmarks/many_logs.py FOLDER [LOGS]

The logs are made in FOLDER, once, from one simulated log and other noise. CPU time is that of the workers: with other programs on the
machine it says more than the wall does.
"""

import sys
import time
from pathlib import Path

import numpy as np
from distributed import Client, LocalCluster

import rivid
from rivid import distributed

REPOSITORY = Path(__file__).resolve().parents[1]
METHOD = rivid.Wls(decimation=20, torque_held=True)


def cpu_seconds() -> float:
    return time.process_time()


def made(folder: Path, count: int) -> list[Path]:
    paths = [folder / f"run_{k:04d}.csv" for k in range(count)]
    if not all(path.exists() for path in paths):
        folder.mkdir(parents=True, exist_ok=True)
        log = rivid.simulate(REPOSITORY / "data/six_axis/simulate.toml").log
        for k, path in enumerate(paths):
            noise = np.random.default_rng(k).normal(size=log.v_tau.shape)
            rivid.Log(log.t, log.q, v_tau=log.v_tau + 0.05 * noise).to_csv(path)
    return paths


def main() -> None:
    folder = Path(sys.argv[1])
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    robot = rivid.Robot.from_urdf(
        REPOSITORY / "data/six_axis/six_axis.urdf", gravity=[0, 0, -9.81], friction="coulomb"
    )
    paths = made(folder, count)
    one = distributed._Plan(robot, distributed._text(METHOD.sections()), 1)
    print(f"factors of one log, 1 block: {len(distributed._factored(paths[:1], one)):,} bytes")
    begin = time.process_time()
    together = rivid.identify(robot, paths, METHOD)
    alone = time.process_time() - begin
    print(f"one process, rivid.identify:   CPU {alone:.1f} s")
    bits = set()
    for workers in (1, 2):
        with (
            LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as client,
        ):
            client.run(rivid_imported)
            before = client.run(cpu_seconds)
            begin = time.perf_counter()
            fit = distributed.identify(robot, paths, METHOD, client=client)
            wall = time.perf_counter() - begin
            after = client.run(cpu_seconds)
        cpu = [after[worker] - before[worker] for worker in before]
        bits.add((fit.chi.tobytes(), fit.covariance.tobytes()))
        print(
            f"{workers} worker(s): wall {wall:.1f} s, CPU {', '.join(f'{seconds:.1f}' for seconds in cpu)} s, "
            f"largest over mean {max(cpu) * workers / sum(cpu):.3f}"
        )
    print(f"the same bits: {len(bits) == 1}")
    shift = np.max(np.abs(fit.chi - together.chi) / np.array(together.sigma))
    print(f"largest difference from one process: {shift:.1e} sigma")
    print(f"sigma over that of one process: {np.median(np.array(fit.sigma) / np.array(together.sigma)):.2f} (median)")


def rivid_imported() -> None:
    """Imports are no part of the time."""
    import rivid.distributed  # noqa: F401


if __name__ == "__main__":
    main()
