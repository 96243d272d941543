"""toppra, copp-py and Ruckig on courses of ours: :class:`guideway.lab.courses.Along` a spline, :class:`guideway.lab.courses.Between` two states."""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

import guideway as gw
from guideway.lab.courses import Along, Between, Timed


def toppra(course: Along, *, seed: int, budget: Mapping[str, Any], intervals: int = 1000) -> Timed:
    """TOPP-RA of the Python package, its seidel solver and its interpolation scheme."""
    del seed, budget
    package, algorithm, constraint = (importlib.import_module(name) for name in ("toppra", "toppra.algorithm", "toppra.constraint"))
    if course.jerk is not None:
        raise gw.BadParameter("toppra knows no limit of jerk")
    logging.getLogger("toppra").setLevel(logging.ERROR)
    grid = np.linspace(0.0, 1.0, intervals + 1)
    both = np.stack([-np.ones(course.joints), np.ones(course.joints)], 1)
    path = package.SplineInterpolator(course.knots, course.curve(course.knots))
    scheme = constraint.DiscretizationType.Interpolation
    limits = [
        constraint.JointVelocityConstraint(course.speed * both),
        constraint.JointAccelerationConstraint(course.acceleration * both, discretization_scheme=scheme),
    ]
    instance = algorithm.TOPPRA(limits, path, gridpoints=grid, solver_wrapper="seidel")
    begun = time.process_time()
    found = instance.compute_parameterization(0, 0, return_data=True)
    seconds = time.process_time() - begun
    if found[1] is None or not np.isfinite(found[1]).all():
        raise gw.Infeasible("toppra found no parameterization")
    return Timed.along(course, grid, np.asarray(found[1]) ** 2, seconds)


def copp(course: Along, *, seed: int, budget: Mapping[str, Any], intervals: int = 1000, jerk: bool = False) -> Timed:
    """copp-py: reachability of second order, and with ``jerk`` its cone program of third order linearised at it."""
    del seed, budget
    package: Any = importlib.import_module("copp_py")
    if jerk != (course.jerk is not None):
        raise gw.BadParameter("copp-py takes courses without a limit of jerk, copp-py-jerk those with one")
    grid, ones = np.linspace(0.0, 1.0, intervals + 1), np.ones(course.joints)
    robot = package.Robot(course.joints, capacity=len(grid))
    robot.append_s(grid)
    q = [np.ascontiguousarray(course.curve(grid, order)) for order in range(4)]
    robot.set_q(q[0], q[1], q[2], 0, **({"dddq": q[3]} if jerk else {}))
    bounds = [(robot.add_velocity_limits, course.speed), (robot.add_acceleration_limits, course.acceleration)]
    for add, bound in [*bounds, *([(robot.add_jerk_limits, course.jerk)] if jerk else [])]:
        add(bound * ones, -bound * ones, start_idx_s=0, length=len(grid))
    begun = time.process_time()
    try:
        problem = package.solver.topp2_ra.Problem(robot.constraints, idx_s_interval=(0, len(grid) - 1), a_boundary=(0.0, 0.0))
        x = np.asarray(package.solver.topp2_ra.solve(problem))
        if not jerk:
            return Timed.along(course, grid, x, time.process_time() - begun)
        robot.constraints.amax_substitute(x, 0)
        profile = package.solver.topp3_socp.solve(package.solver.topp3_socp.Problem(robot.constraints, x))
    except package.CoppError as error:
        raise gw.Infeasible(f"copp-py: {error}") from None
    seconds = time.process_time() - begun
    duration, _ = package.interpolation.s_to_t_topp3(grid, profile, 0.0)
    return Timed.third(course, grid, np.asarray(profile.a), np.asarray(profile.b), float(duration), seconds)


def ruckig(course: Between, *, seed: int, budget: Mapping[str, Any]) -> Timed:
    """Ruckig's community version, offline, axes synchronised in time."""
    del seed, budget
    package: Any = importlib.import_module("ruckig")
    asked = package.InputParameter(len(course.start))
    asked.current_position, asked.target_position = course.start.tolist(), course.goal.tolist()
    for name in ("velocity", "acceleration"):
        setattr(asked, f"current_{name}", course.ends[f"start_{name}"].tolist())
        setattr(asked, f"target_{name}", course.ends[f"goal_{name}"].tolist())
        setattr(asked, f"max_{name}", course.limits[name].tolist())
        setattr(asked, f"min_{name}", course.limits[f"min_{name}"].tolist())
    asked.max_jerk = course.limits["jerk"].tolist()
    planner, trajectory = package.Ruckig(len(course.start)), package.Trajectory(len(course.start))
    begun = time.process_time()
    try:
        result = planner.calculate(asked, trajectory)
    except (package.RuckigError, ValueError) as error:
        raise gw.Infeasible(f"Ruckig: {' '.join(str(error).split())[:200]}") from None
    seconds = time.process_time() - begun
    if result not in (package.Result.Working, package.Result.Finished):
        raise gw.Infeasible(f"Ruckig: {result}")
    times = course.times(trajectory.duration)
    rows = [trajectory.at_time(float(t)) for t in times]
    q, qd, qdd = (np.array([row[k] for row in rows]) for k in range(3))
    return Timed.between(course, trajectory.duration, (q, qd, qdd), seconds)
