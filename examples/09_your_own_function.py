"""The optimizers on a function of your own: a crane's trolley that shall be quick and swing little, with a limit on the swing."""

import numpy as np

import guideway as gw

LENGTH, GRAVITY, WAY = 4.0, 9.81, 6.0  # rope in m, m/s2, distance in m


def crane(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Time (s) and broken swing limit (rad) of many candidates: acceleration, cruise time, deceleration; shape (n, 3)."""
    accelerate, cruise, brake = x.T
    duration = accelerate + cruise + brake
    speed = WAY / (0.5 * accelerate + cruise + 0.5 * brake)
    frequency = np.sqrt(GRAVITY / LENGTH)
    swing = 2 * speed / (GRAVITY * accelerate) * np.abs(np.sin(0.5 * frequency * accelerate)) + 2 * speed / (GRAVITY * brake) * np.abs(
        np.sin(0.5 * frequency * brake)
    )
    return duration, np.maximum(0.0, swing - 0.01) + np.maximum(0.0, speed - 2.5)


for method in ("l-shade", "cma-es", "improved-de"):
    found = gw.minimize(crane, bounds=[(0.2, 10.0), (0.0, 20.0), (0.2, 10.0)], method=method, seed=1, budget=6000, vectorized=True)
    times = ", ".join(f"{value:.3f}" for value in found.x)
    print(f"{method:<12} {found.value:.4f} s (phases {times} s), violation {found.violation:.0e}, {found.evaluations} evaluations")
    assert found.violation == 0.0
    if method != "cma-es":  # which may end in another of the many valleys
        assert found.value < 8.0
