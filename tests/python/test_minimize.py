"""Minimising a user's own function: what comes back, and what happens when something is wrong."""

import math
import signal
import threading
import time

import numpy as np
import pytest

import guideway as gw

METHODS = [entry["name"] for entry in gw.optimizers()]
BOX = [(-5.0, 5.0)] * 3


def sphere(x):
    return float(((x - 1.0) ** 2).sum())


def rows(x):
    return ((x - 1.0) ** 2).sum(axis=1)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_minimises_a_python_function(method):
    found = gw.minimize(sphere, BOX, method, seed=1, budget=2500)
    assert found.value < 0.5 if method == "sparrow" else found.value < 1e-2
    assert found.value == sphere(found.x)
    assert found.violation == 0
    assert found.method == method
    assert found.seed == 1
    assert found.evaluations <= 2500
    assert found.iterations > 5
    assert found.stop in ("budget", "converged")
    assert found.population.shape[1] == 3
    assert found.costs.shape == (len(found.population), 2)
    assert found.history.shape[1] == 3
    assert found.history[-1, 1] == found.value
    assert np.all(np.diff(found.history[:, 1]) < 0)
    assert np.all(np.diff(found.history[:, 0]) > 0)


@pytest.mark.parametrize("method", METHODS)
def test_calls_one_by_one_at_once_and_on_threads_find_the_same(method):
    found = [
        gw.minimize(sphere, BOX, method, seed=3, budget=700),
        gw.minimize(rows, BOX, method, seed=3, budget=700, vectorized=True),
        gw.minimize(sphere, BOX, method, seed=3, budget=700, threads=3),
        gw.minimize(sphere, BOX, method, seed=3, budget=gw.Budget(evaluations=700)),
        gw.minimize(sphere, BOX, method, seed=3, budget={"evaluations": 700}, observe=lambda p: False),
    ]
    for other in found[1:]:
        assert np.allclose(other.x, found[0].x, rtol=1e-9)
        assert other.evaluations == found[0].evaluations
    assert not np.array_equal(found[0].x, gw.minimize(sphere, BOX, method, seed=4, budget=700).x)


def test_compiled_functions_by_name():
    for name, at in [("sphere", 0), ("rosenbrock", 1), ("rastrigin", 0), ("ackley", 0), ("griewank", 0)]:
        found = gw.minimize(name, [(-4.0, 3.0)] * 4, seed=2, budget=30_000)
        assert found.value < 1e-6, name
        assert np.allclose(found.x, at, atol=1e-3), name
    with pytest.raises(gw.BadParameter, match="one of sphere, rosenbrock"):
        gw.minimize("sphere2", BOX, budget=100)


def test_feasible_candidates_come_first():
    def f(x):
        return float(x.sum()), max(0.0, 1.0 - x[0])

    found = gw.minimize(f, BOX, budget=6000)
    assert found.violation == 0
    assert np.allclose(found.x, [1, -5, -5], atol=1e-4)

    def columns(x):
        return x.sum(axis=1), np.maximum(0.0, 1.0 - x[:, 0])

    assert np.allclose(gw.minimize(columns, BOX, budget=6000, vectorized=True).x, found.x, atol=1e-9)


def test_an_infinite_value_means_not_allowed():
    found = gw.minimize(lambda x: math.inf if x[0] < 2 else float((x**2).sum()), BOX, budget=8000)
    assert found.violation == 0
    assert np.allclose(found.x, [2, 0, 0], atol=1e-3)
    nothing = gw.minimize(lambda x: math.inf, BOX, budget=100)
    assert nothing.value == math.inf
    assert nothing.violation == math.inf


@pytest.mark.parametrize("method", METHODS)
def test_hints_are_judged_first(method):
    seen = []

    def f(x):
        seen.append(x.copy())
        return sphere(x)

    found = gw.minimize(f, BOX, method, budget=60, hints=[1.0, 1.0, 1.0])
    assert found.value == 0
    assert np.array_equal(seen[0], [1, 1, 1])
    assert gw.minimize(f, BOX, method, budget=60, hints=[[0, 0, 0], [1, 1, 1]]).value == 0
    assert all(np.all(np.abs(x) <= 5) for x in seen)


def test_the_observer_sees_progress_and_stops():
    seen = []

    def observe(progress):
        seen.append(progress)
        return progress["evaluations"] > 200

    found = gw.minimize(lambda x: (time.sleep(0.001), sphere(x))[1], BOX, budget=10**6, observe=observe)
    assert found.stop == "cancelled"
    assert 200 < found.evaluations < 10_000
    assert math.isfinite(found.value)
    assert [p["evaluations"] for p in seen] == sorted(p["evaluations"] for p in seen)


def error(*words, f=sphere, bounds=BOX, **options):
    with pytest.raises(gw.BadParameter) as caught:
        gw.minimize(f, bounds, **({"budget": 500} | options))
    text = str(caught.value)
    assert all(word in text for word in words), text
    assert len(text) < 700


def test_bad_boxes_budgets_methods_and_parameters_are_named():
    error("bounds[1]", bounds=[(0, 1), (1, 0)])
    error("bounds[0]", bounds=[(0, math.inf)])
    error("bounds[0]", bounds=[(math.nan, 1)])
    error("bounds", "shape", bounds=[])
    error("bounds", "none", bounds=np.zeros((0, 2)))
    error("bounds", "shape", bounds=[(0, 1, 2)])
    error("bounds", bounds="box")
    for budget in (None, 0, -1, 1.5, math.nan, gw.Budget(), gw.Budget(evaluations=0), gw.Budget(iterations=0), gw.Budget(seconds=0.0), "many"):
        error("budget", budget=budget)
    error("l-shade, cma-es", "simplex", method="simplex")
    error("l-shade.size", "population", set={"size": 3})
    error("population", set={"population": 3})
    error("scale", method="de", set={"scale": "big"})
    error("hints", hints=[1.0, 2.0])
    error("hints", hints=[[1.0, 2.0, math.nan]])
    error("f", "function", f=3)


def test_bad_answers_say_for_which_x():
    error("f(x)", "NaN", "x = [", f=lambda x: math.nan)
    error("f(x)", "-inf", f=lambda x: -math.inf)
    error("violation", "x = [", f=lambda x: (1.0, -1.0))
    error("f(x)", "NoneType", f=lambda x: None)
    error("f(x)", "shape (3,)", f=lambda x: x)
    error("f(x)", "a number, or (value, violation)", f=lambda x: "1")
    error("f(X)", "shape (", f=lambda x: rows(x)[:7], vectorized=True)
    error("f(X)", "shape ()", f=lambda x: 1.0, vectorized=True)
    error("NaN", "x = [", f=lambda x: rows(x) * math.nan, vectorized=True)
    error("x = [", "...", f=lambda x: math.nan, bounds=[(0, 1)] * 60)


class OwnError(Exception):
    pass


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("vectorized", [False, True])
def test_an_exception_of_the_function_ends_the_run_as_it_is(method, vectorized):
    calls = []
    raised = OwnError("mine")

    def f(x):
        calls.append(1)
        if len(calls) > 3:
            raise raised
        return rows(x) if vectorized else sphere(x)

    with pytest.raises(OwnError) as caught:
        gw.minimize(f, BOX, method, budget=10**9, vectorized=vectorized)
    assert caught.value is raised
    assert len(calls) == 4


def test_an_exception_of_the_observer_is_raised():
    def observe(progress):
        raise OwnError

    with pytest.raises(OwnError):
        gw.minimize("sphere", BOX, budget=10**9, observe=observe)


@pytest.mark.parametrize("f", ["rosenbrock", sphere])
def test_ctrl_c_returns_promptly_with_what_was_found(f):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the tests run in the background
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt) as caught:
            gw.minimize(f, BOX, "de", budget=gw.Budget(evaluations=10**10, seconds=30.0))
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert caught.value.minimum.evaluations > 0
    assert math.isfinite(caught.value.minimum.value)


def test_a_budget_in_seconds_ends_a_slow_function():
    found = gw.minimize(lambda x: (time.sleep(0.02), sphere(x))[1], BOX, budget=gw.Budget(seconds=0.3))
    assert found.stop == "budget"
    assert 0 < found.evaluations < 40


def test_the_list_of_optimizers_is_complete():
    assert METHODS[0] == "l-shade"
    assert {"de", "improved-de", "firefly", "cma-es", "pso", "grouped-pso", "sparrow"} < set(METHODS)
    for entry in gw.optimizers():
        assert entry["about"]
        assert entry["source"]
        assert all(p["about"] and p["default"] is not None for p in entry["parameters"])
        defaults = {p["name"]: p["default"] for p in entry["parameters"]}
        assert gw.minimize("sphere", BOX, entry["name"], budget=50, set=defaults).evaluations == 50
