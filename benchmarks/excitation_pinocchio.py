"""The gradient of an excitation's design beside the way of Python tools: Pinocchio's regressor and differences.

Both take −log det of the information matrix of a Fourier series of five harmonics at 200 samples. rivid's time includes
all limits and their Jacobian, that of the torques among them; the other's does not.

    python3 -m venv venv && venv/bin/pip install pin
    venv/bin/python benchmarks/excitation_pinocchio.py build/test/benchmarks/benchmark_excitation ROBOT.urdf
"""

import json
import subprocess
import sys
import time

import numpy as np
import pinocchio as pin

DURATION, HARMONICS, SAMPLES = 15.0, 5, 200
STEP = 1e-6


class Criterion:
    def __init__(self, urdf):
        self.model = pin.buildModelFromUrdf(urdf)
        self.data = self.model.createData()
        n = self.model.nv
        t = (np.arange(SAMPLES) + 0.5) * DURATION / SAMPLES
        w = 2 * np.pi / DURATION * np.arange(1, HARMONICS + 1)
        sines, cosines = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
        self.position = np.hstack([sines / w, -cosines / w])
        self.velocity = np.hstack([cosines, sines])
        self.acceleration = np.hstack([-sines * w, cosines * w])
        random = np.random.default_rng(1)
        # Columns that are independent along random motions, friction and rotors besides.
        some = self.rows(*random.normal(size=(3, SAMPLES, n)))
        kept = []
        for column in range(some.shape[1]):
            if np.linalg.matrix_rank(some[:, [*kept, column]], tol=1e-8) > len(kept):
                kept.append(column)
        self.kept = kept

    def rows(self, q, v, a):
        n = self.model.nv
        out = np.zeros((len(q) * n, 10 * n + 4 * n))
        for k in range(len(q)):
            rows = slice(k * n, (k + 1) * n)
            out[rows, : 10 * n] = pin.computeJointTorqueRegressor(self.model, self.data, q[k], v[k], a[k])
            friction = np.vstack([a[k], v[k], np.tanh(v[k] / 0.05), np.ones(n)])
            for j in range(n):
                out[k * n + j, 10 * n + 4 * j : 10 * n + 4 * j + 4] = friction[:, j]
        return out

    def __call__(self, x):
        c = x.reshape(2 * HARMONICS, self.model.nv)
        W = self.rows(self.position @ c, self.velocity @ c, self.acceleration @ c)[:, self.kept]
        return -np.linalg.slogdet(W.T @ W)[1]

    def gradient(self, x):
        value = self(x)
        return np.array([(self(x + STEP * e) - value) / STEP for e in np.eye(len(x))])


def seconds(f, runs):
    times = []
    for _ in range(runs):
        start = time.process_time()
        f()
        times.append(time.process_time() - start)
    return np.median(times)


def main():
    program, urdf = sys.argv[1:]
    criterion = Criterion(urdf)
    x = 0.3 * np.random.default_rng(2).normal(size=2 * HARMONICS * criterion.model.nv)
    own = []
    for _ in range(3):  # they take turns
        own.append(json.loads(subprocess.run([program, urdf], check=True, capture_output=True).stdout))
        differences = 1e3 * seconds(lambda: criterion.gradient(x), 3)
        value = 1e3 * seconds(lambda: criterion(x), 9)
    best = sorted(own, key=lambda o: o["gradient_ms"])[1]
    print(f"{len(criterion.kept)} parameters, {len(x)} variables")
    print(f"Pinocchio, NumPy: criterion {value:.2f} ms, gradient by differences {differences:.1f} ms")
    print(
        f"rivid ({best['parameters']} parameters, {best['variables']} variables): criterion and limits "
        f"{best['criterion_ms']:.3f} ms, with gradient and Jacobian {best['gradient_ms']:.3f} ms"
    )
    print(f"gradients: {differences / best['gradient_ms']:.0f} times")


if __name__ == "__main__":
    main()
