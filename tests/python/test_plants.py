"""Plants that are Python objects: the seam, and the mobile base in MuJoCo."""

import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest

import guideway as gw
from guideway.plants import measures, movers, room


class Exact:
    """A unicycle without lag or noise, exact arcs."""

    def __init__(self, pose=(0.0, 0.0, 0.0)):
        self.pose, self.speeds, self.time, self.calls = list(pose), (0.0, 0.0), 0.0, 0

    def observe(self):
        self.calls += 1
        return {"time": self.time, "pose": np.asarray(self.pose), "v": self.speeds[0], "w": self.speeds[1]}

    def step(self, v, w, dt):
        x, y, yaw = self.pose
        middle = yaw + 0.5 * w * dt
        self.pose = [x + v * dt * math.cos(middle), y + v * dt * math.sin(middle), yaw + w * dt]
        self.speeds, self.time = (v, w), self.time + dt

    def motion(self):
        return {"pose": self.pose, "v": self.speeds[0], "w": self.speeds[1]}


@pytest.fixture(scope="module")
def corridor():
    world = gw.World(bounds=(0, -2, 6, 2), shapes=[{"disc": {"center": [3.0, 1.2], "radius": 0.4}}])
    query = gw.Query(world, (0.5, 0.0), (5.0, 0.0), footprint=gw.Disc(0.25), clearance=0.05)
    return query, gw.time(gw.plan(query).path, gw.Limits(1.0, 1.0, jerk=4.0))


def test_an_object_is_driven_and_named_in_the_record(corridor):
    plant = Exact((0.5, 0.0, 0.0))
    run = gw.drive(*corridor, "tracker", plant=plant)
    assert run["outcome"] == "arrived"
    assert run["plant"] == {"name": "Exact"}
    assert plant.calls > 100
    assert plant.time == pytest.approx(run["driven"][-1][0])
    assert np.allclose(run["driven"][-1][1:4], plant.pose)
    assert run["tracking"]["tte"] < 0.002


def test_a_hair_outside_both_borders_of_a_corner_is_no_collision():
    query = gw.Query(gw.World(bounds=(0, 0, 6, 4)), (0.0, 0.0), (3.0, 2.0))
    motion = gw.time(gw.plan(query).path, gw.Limits(1.0, 1.0))
    assert gw.drive(query, motion, "tracker", plant=Exact((-1e-9, -1e-9, math.atan2(2, 3))))["outcome"] == "arrived"
    assert gw.drive(query, motion, "tracker", plant=Exact((-0.06, -0.06, math.atan2(2, 3))))["collision"]["with"] == "border"


def test_what_an_object_measured_is_in_the_record(corridor):
    plant = Exact((0.5, 0.0, 0.0))
    plant.extras = lambda: {"name": "cart", "wear": 0.5}
    assert gw.drive(*corridor, "tracker", plant=plant)["plant"] == {"name": "cart", "wear": 0.5}


def test_an_object_says_how_far_it_is_from_the_model_of_a_base(corridor):
    plant = Exact((0.5, 0.0, 0.0))
    plant.error = -1.0
    with pytest.raises(gw.BadParameter, match=r"improved-dwa\.error"):
        gw.drive(*corridor, plant=plant)
    assert gw.drive(*corridor, plant=plant, set={"error": 0.01})["outcome"] == "arrived"
    assert gw.drive(*corridor, "tracker", plant=Exact((0.5, 0.0, 0.0)))["outcome"] == "arrived"


def test_a_motion_that_turns_faster_than_the_base_is_timed_anew():
    world = gw.World(bounds=(0, 0, 10, 10), shapes=[{"disc": {"center": [5.0, 4.6], "radius": 0.4}}])
    query = gw.Query(world, (1.0, 5.0), (9.0, 5.0), via=[(5.0, 5.5), (5.5, 4.0)], footprint=gw.Disc(0.25), clearance=0.05)
    path, limits = gw.refine(gw.plan(query).path, query).path, gw.Limits(1.0, 1.0, jerk=5.0)
    fast, slow = gw.time(path, limits), gw.time(path, gw.Limits(1.0, 1.0, jerk=5.0, turn_rate=1.0, turn_acceleration=2.0))
    states = fast.sample()
    assert np.abs(states[:, 4] * states[:, 7]).max() > 1.1
    run, again = (gw.drive(query, motion, "tracker") for motion in (fast, slow))
    assert run["driven"] == again["driven"]
    assert (run["outcome"], run["plan"]["duration"], run["robot"]["turn_rate"]) == ("arrived", slow.duration, 1.0)
    # a plant of one's own may turn as it likes
    assert gw.drive(query, fast, "tracker", plant=Exact((*query.start, fast.at(0.0)["pose"][2])))["plan"]["duration"] == fast.duration


def test_what_an_object_raises_is_raised_at_once(corridor):
    class Broken(Exact):
        def step(self, v, w, dt):
            if self.time > 1.0:
                raise ZeroDivisionError("wheel lost")
            super().step(v, w, dt)

    plant = Broken((0.5, 0.0, 0.0))
    with pytest.raises(ZeroDivisionError, match="wheel lost"):
        gw.drive(*corridor, "tracker", plant=plant)
    assert plant.calls == pytest.approx(51, abs=2), "the run ends in the step that failed"


@pytest.mark.parametrize(
    ("method", "answer", "kind"),
    [
        ("observe", {"time": 0.0, "pose": (0, 0), "v": 0.0, "w": 0.0}, gw.BadParameter),
        ("observe", {"time": 0.0, "pose": (0, 0, math.nan), "v": 0.0, "w": 0.0}, gw.BadParameter),
        ("motion", {"pose": (0, 0, 0), "v": math.inf, "w": 0.0}, gw.BadParameter),
        ("motion", {"pose": (0, 0, 0), "w": 0.0}, KeyError),
        ("motion", None, TypeError),
    ],
)
def test_wrong_answers_are_errors(corridor, method, answer, kind):
    plant = Exact((0.5, 0.0, 0.0))
    setattr(plant, method, lambda: answer)
    with pytest.raises(kind):
        gw.drive(*corridor, "tracker", plant=plant)


def test_what_is_no_plant_is_refused(corridor):
    with pytest.raises(gw.BadParameter, match="observe"):
        gw.drive(*corridor, plant=object())
    with pytest.raises(gw.BadParameter, match="one of unicycle, mujoco"):
        gw.drive(*corridor, plant="bicycle")
    with pytest.raises(gw.BadParameter, match="no setting"):
        gw.plants.make("unicycle", *corridor, settings={"mass": 3})
    assert isinstance(Exact(), gw.plants.Plant)
    assert not isinstance(object(), gw.plants.Plant)


def test_settings_out_of_range_are_refused():
    for settings in ({"mass": -1.0}, {"height": math.nan}, {"height": 0.05}, {"friction": "much"}, {"wheels": 4}, {"lag_turn": True}):
        with pytest.raises(gw.BadParameter):
            gw.plants.Settings.of(settings)


def test_rectangles_cover_the_blocked_cells_and_no_other():
    blocked = np.random.Generator(np.random.PCG64(4)).random((40, 31)) < 0.4
    covered = np.zeros_like(blocked, dtype=int)
    found = room.rectangles(blocked)
    for column, row, width, height in found:
        covered[row : row + height, column : column + width] += 1
    assert np.array_equal(covered, blocked.astype(int))
    assert room.rectangles(np.ones((5, 7), dtype=bool)) == [(0, 0, 7, 5)]


def test_boxes_lie_where_the_cells_of_a_turned_map_lie():
    world = gw.World([[0, 1, 1], [0, 0, 0]], 0.5, (2.0, 3.0, math.pi / 2))
    [(x, y, yaw, length, width)] = room.boxes(world)
    centers = world.cell_centers([[1, 0], [2, 0]])
    assert np.allclose([x, y], np.asarray(centers).mean(axis=0))
    assert (yaw, length, width) == pytest.approx((math.pi / 2, 1.0, 0.5))


def test_movers_are_where_the_record_has_them():
    track = [[0.0, 1.0, 1.5], [2.0, 3.0, 1.5], [3.0, 3.0, -1.5]]
    loops = [{"shape": {"disc": 0.1}, "track": track, "loop": loop, "phase": 0.7} for loop in ("once", "cycle", "shuttle")]
    world = gw.World(bounds=(0, -2, 6, 2), movers=loops)
    query = gw.Query(world, (0.3, 0.0), (5.7, 0.0))
    run = gw.drive(query, gw.time(gw.plan(query).path, gw.Limits(0.5, 0.5)), "tracker", time_limit=9.0)
    for mover, recorded in zip(world.movers, run["movers"], strict=True):
        for t, x, y, _ in recorded["states"]:
            assert movers.position(mover, t) == pytest.approx((x, y), abs=1e-4)


def test_indices_of_a_known_tilt():
    rows = np.array([[0.0, 9.0, 9.0], [1.0, 3.0, 4.0], [2.0, -6.0, 8.0], [3.0, 9.0, 9.0]])
    found = measures.stability(rows, (0.5, 2.5))
    assert (found["max"], found["mean"], found["rms"]) == pytest.approx((10.0, 7.5, math.sqrt(62.5)))
    assert found["ms"] == pytest.approx(70.0)
    assert found["psi"] == pytest.approx(100 * (1 - math.sqrt(62.5) / 25))


def test_a_touch_counts_once_until_it_was_free():
    gauge = measures.Gauge()
    for t in (0.1, 0.15, 0.2, 0.9):
        gauge.touch(t, {"static 0"})
    gauge.touch(0.95, {"static 0", "mover 1"})
    assert [(row["t"], row["with"]) for row in gauge.touched] == [(0.1, "static 0"), (0.9, "static 0"), (0.95, "mover 1")]


def test_without_the_simulator_the_error_says_what_to_install(corridor, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"pip install 'guideway\[mujoco\]'"):
        gw.drive(*corridor, plant="mujoco")


class TestMuJoCo:
    """Skipped only where MuJoCo cannot be imported."""

    @pytest.fixture(autouse=True)
    def _simulator(self):
        pytest.importorskip("mujoco")

    @staticmethod
    def base(corridor, **settings):
        return gw.plants.make("mujoco", *corridor, seed=3, settings=settings)

    def test_it_stands_still_and_level_at_the_start(self, corridor):
        plant = self.base(corridor)
        assert plant.motion()["pose"] == pytest.approx((0.5, 0.0, 0.0), abs=1e-6)
        for _ in range(100):
            plant.step(0.0, 0.0, 0.01)
        found = plant.extras()
        assert plant.motion()["pose"] == pytest.approx((0.5, 0.0, 0.0), abs=1e-4)
        assert found["tilt"]["max"] < 0.05
        assert found["contacts"] == 0

    def test_its_springs_carry_its_weight(self, corridor):
        plant = self.base(corridor, mass=60.0)
        assert plant.model.body_mass.sum() == pytest.approx(60.0, rel=0.02)
        springs = [plant.data.qpos[plant.model.jnt_qposadr[j]] for j in range(plant.model.njnt) if plant.model.jnt_type[j] == 2]
        assert len(springs) == 4
        assert np.abs(springs).max() < 2e-3, "in the middle of their way"

    def test_it_drives_as_far_as_it_is_told(self, corridor):
        plant = self.base(corridor)
        for _ in range(300):
            plant.step(0.5, 0.0, 0.01)
        x, y, _ = plant.motion()["pose"]
        assert x == pytest.approx(0.5 + 0.5 * 3.0 - 0.5 * (0.08 + 0.25), abs=0.05)
        assert abs(y) < 0.01
        assert plant.motion()["v"] == pytest.approx(0.5, rel=0.02)

    def test_it_turns_left_for_a_positive_rate(self, corridor):
        plant = self.base(corridor)
        for _ in range(100):
            plant.step(0.0, 0.8, 0.01)
        assert plant.motion()["w"] == pytest.approx(0.8, rel=0.05)
        assert 0.5 < plant.motion()["pose"][2] < 0.8

    def test_braking_noses_down_and_a_left_bend_leans_right(self, corridor):
        plant = self.base(corridor)
        for _ in range(300):
            plant.step(1.0, 0.0, 0.01)
        for _ in range(10):
            plant.step(0.0, 0.0, 0.01)
        assert plant.gauge.rows[-1][1] > 0.5, "pitch is positive nose down"
        plant = self.base(corridor)
        for _ in range(150):
            plant.step(1.0, 1.0, 0.01)
        assert plant.gauge.rows[-1][2] > 0.2, "roll is positive to the right"

    def test_a_higher_centre_of_gravity_tilts_more(self, corridor):
        low, high = (gw.drive(*corridor, "tracker", plant=self.base(corridor, height=h))["plant"] for h in (0.15, 0.35))
        assert high["tilt"]["rms"] > 1.5 * low["tilt"]["rms"]
        assert high["tilt"]["psi"] < low["tilt"]["psi"]

    def test_a_slippery_floor_slips(self, corridor):
        query, _ = corridor
        motion = gw.time(gw.plan(query).path, gw.Limits(1.0, 2.5), method="trapezoid")
        dry, wet, careful = (
            gw.drive(query, motion, "tracker", plant=gw.plants.make("mujoco", query, motion, settings={"friction": mu} | held), time_limit=30.0)[
                "plant"
            ]
            for mu, held in ((1.0, {}), (0.1, {"margin": 0.0}), (0.1, {}))
        )
        assert wet["slip"]["max"] > 0.5 > 2 * dry["slip"]["max"]
        assert careful["slip"]["max"] < 0.2, "driven as the wheels can hold"

    def test_the_work_is_what_motion_and_drag_take(self, corridor):
        run = gw.drive(*corridor, "tracker", plant=self.base(corridor))
        energy, top = run["plant"]["energy"], max(row[4] for row in run["driven"])
        drag = 0.015 * 40 * 9.81 * run["tracking"]["length"]
        kinetic = 0.5 * 40 * top**2
        assert energy["work"] - energy["braked"] == pytest.approx(drag, rel=0.35)
        assert energy["work"] == pytest.approx(drag + kinetic, rel=0.35)

    def test_the_same_seed_gives_the_same_run(self, corridor):
        first, second = (gw.drive(*corridor, "tracker", plant="mujoco", seed=5) for _ in range(2))
        assert first["driven"] == second["driven"]
        assert first["plant"] == second["plant"]
        assert gw.drive(*corridor, "tracker", plant="mujoco", seed=6)["driven"] != first["driven"]

    def test_walls_boxes_and_movers_are_touched(self):
        shapes = [{"disc": {"center": [2.0, 0.0], "radius": 0.3}}]
        triangle = [{"polygon": {"points": [[1.7, -0.4], [2.3, -0.4], [2.0, 0.6]]}}]
        cells = np.zeros((20, 40), dtype=bool)
        cells[8:12, 17:20] = True
        still = {"shape": {"box": [0.6, 0.6]}, "track": [[0.0, 2.0, 0.0]], "loop": "once", "phase": 0.0}
        later = still | {"appears": {"within": 1.0}}
        bounds, origin = (0, -1, 4, 1), (0.0, -1.0, 0.0)
        rooms = {
            "static 0": [gw.World(bounds=bounds, shapes=shapes), gw.World(bounds=bounds, shapes=triangle)],
            "cells 0": [gw.World(cells, 0.1, origin)],
            "mover 0": [gw.World(bounds=bounds, movers=[still]), gw.World(bounds=bounds, movers=[later])],
        }
        free = gw.Query(gw.World(bounds=bounds), (0.5, 0.0), (3.5, 0.0), footprint=gw.Disc(0.25))
        motion = gw.time(gw.plan(free).path, gw.Limits(1.0, 1.0))
        for name, worlds in rooms.items():
            for world in worlds:
                plant = gw.plants.MobileBase(gw.Query(world, (0.5, 0.0), (3.5, 0.0), footprint=gw.Disc(0.25)), motion)
                for _ in range(250):
                    plant.step(0.6, 0.0, 0.01)
                assert [row["with"] for row in plant.extras()["touched"]][:1] == [name]
                assert plant.motion()["pose"][0] < 1.9

    @pytest.mark.parametrize("footprint", [{"box": [0.8, 0.5]}, {"polygon": [[-0.3, -0.3], [0.6, -0.2], [0.6, 0.2], [-0.3, 0.3]]}, {"disc": 0.0}])
    def test_every_footprint_becomes_a_body_that_arrives(self, footprint):
        query = gw.Query(gw.World(bounds=(0, -2, 6, 2)), (0.8, 0.0), (5.0, 0.5), footprint=footprint)
        motion = gw.time(gw.plan(query).path, gw.Limits(0.8, 0.6))
        run = gw.drive(query, motion, "tracker", plant="mujoco")
        assert run["outcome"] == "arrived"
        assert run["plant"]["contacts"] == 0
        assert run["plant"]["tilt"]["max"] < 10

    def test_w0_with_its_movers_is_driven_by_the_default_controller(self):
        world = gw.scenes.load("w0", seed=0).query("dynamic").world
        query = gw.Query(world, (0.0, 0.0), (5.0, 3.0), footprint=gw.Disc(0.25), clearance=0.05)
        motion = gw.time(gw.plan(query).path, gw.Limits(1.0, 1.0, jerk=4.0, turn_rate=2.0, turn_acceleration=4.0))
        run = gw.drive(query, motion, plant="mujoco", seed=0)  # springs let the body lean out of its footprint: error is 0.04
        again = gw.drive(query, motion, plant="mujoco", seed=0, set={"error": 0.04}, time_limit=2.0)
        assert run["driven"][:100] == again["driven"][:100]
        assert (run["outcome"], run["collision"]) == ("arrived", None)
        assert run["min_separation"] > 0.0
        assert run["plant"]["contacts"] == 0
        assert run["plant"]["tilt"]["max"] < 5.0
        assert run["plant"]["slip"]["max"] < 0.2

    @pytest.mark.parametrize(("height", "wheel"), [(0.2, 0.08), (0.3, 0.08), (0.1, 0.05)])
    def test_what_it_says_it_can_hold_keeps_all_feet_on_the_floor(self, height, wheel):
        query = gw.Query(gw.World(bounds=(0, -2, 9, 2)), (0.8, 0.0), (8.0, 0.0), footprint=gw.Disc(0.25))
        motion = gw.time(gw.plan(query).path, gw.Limits(2.0, 5.0, jerk=100.0))
        loose, sure = ({"height": height, "wheel": wheel, "margin": margin} for margin in (0.0, 0.65))
        plant = gw.plants.make("mujoco", query, motion, settings=sure)
        held = plant.limits
        assert held["deceleration"] == pytest.approx(0.65 * 9.81 * min(0.32 * 0.25 / height, 0.6 / math.sqrt(2)))
        run = gw.drive(query, motion, "tracker", plant=plant)
        assert run["plant"]["limits"]["asked"]["deceleration"] == 5.0
        assert run["plant"]["limits"]["held"] | {"footprint": query.footprint} == run["robot"]
        assert (run["outcome"], run["robot"]["acceleration"]) == ("arrived", held["acceleration"])
        assert run["plant"]["slip"]["max"] < 0.2
        assert gw.plants.make("mujoco", query, motion, settings=loose).limits == {}
        assert "limits" not in gw.drive(query, gw.time(motion.path, gw.Limits(1.0, 1.0)), "tracker", plant="mujoco")["plant"]

    def test_the_room_as_it_is_asked_for_is_driven_as_the_base_can(self):
        scene = gw.scenes.load("w0", seed=0)
        query = scene.query("dynamic")
        motion = gw.time(gw.plan(query).path, scene.limits)
        run = gw.drive(query, motion, plant="mujoco", seed=0)
        assert (run["outcome"], run["plant"]["contacts"]) == ("arrived", 0)
        assert run["query"]["footprint"] == {"disc": 0.25} == run["plant"]["body"]
        assert run["query"]["clearance"] == pytest.approx(0.05)
        assert run["plant"]["tilt"]["max"] < 8.0
        assert run["plant"]["slip"]["max"] < 0.3

    def test_a_simulation_that_comes_apart_is_an_error(self, corridor):
        plant = self.base(corridor)
        plant.data.qvel[:] = 1e7
        with pytest.raises(gw.BadParameter, match="came apart"):
            gw.drive(*corridor, "tracker", plant=plant)

    def test_the_record_keeps_its_schema_and_the_command_its_words(self, corridor, tmp_path):
        jsonschema = pytest.importorskip("jsonschema")
        scene = tmp_path / "room.toml"
        scene.write_text(
            "[world]\nbounds = [0, -2, 6, 2]\n[robot]\nfootprint = { disc = 0.25 }\nspeed = 1.0\nacceleration = 1.0\njerk = 4.0\n"
            "[query]\nstart = [0.5, 0.0]\ngoal = [3.0, 0.0]\n"
        )
        words = [
            sys.executable,
            "-m",
            "guideway",
            "drive",
            str(scene),
            "--plant",
            "mujoco",
            "--controller",
            "tracker",
            "--plant-set",
            "height=0.3",
            "--json",
        ]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        run = json.loads(done.stdout)
        jsonschema.validate(run, gw.schemas.load("run"))
        assert (run["plant"]["name"], run["plant"]["height"], run["plant"]["contacts"]) == ("mujoco", 0.3, 0)
        for wrong in (
            ["--plant", "bicycle"],
            ["--plant", "mujoco", "--plant-set", "heights=1"],
            ["--video", "a.gif"],
            ["--plant", "mujoco", "--video", "a.avi"],
        ):
            done = subprocess.run([*words[:5], *wrong], capture_output=True, text=True, timeout=300)
            assert done.returncode == 2, wrong
            assert "Traceback" not in done.stderr

    def test_a_graphics_library_that_is_not_there_costs_the_film_alone(self, tmp_path):
        scene = tmp_path / "room.toml"
        scene.write_text("[world]\nbounds = [0, -2, 6, 2]\n[robot]\nfootprint = { disc = 0.25 }\n[query]\nstart = [0.5, 0.0]\ngoal = [1.0, 0.0]\n")
        words = [sys.executable, "-m", "guideway", "drive", str(scene), "--plant", "mujoco", "--video", str(tmp_path / "run.gif")]
        done = subprocess.run(words, capture_output=True, text=True, timeout=300, env={**os.environ, "MUJOCO_GL": "disabled"})
        assert done.returncode == 0, done.stderr
        assert "arrived" in done.stdout
        assert done.stderr.startswith("no film: this machine cannot render")
        assert not (tmp_path / "run.gif").exists()

    def test_a_film_is_written_or_a_clear_reason_given(self, corridor, tmp_path):
        from guideway.plants import film

        plant = self.base(corridor)
        for _ in range(30):
            plant.step(0.5, 0.2, 0.02)
        try:
            film.save(plant, tmp_path / "run.gif", size=(96, 60))
        except film.NoPicture:
            with pytest.raises(film.NoPicture, match="MUJOCO_GL"):
                film.save(plant, tmp_path / "run.png")
            return
        film.save(plant, tmp_path / "run.png", size=(192, 120))
        from PIL import Image

        with Image.open(tmp_path / "run.gif") as images:
            assert images.size == (96, 60)
            assert images.n_frames > 5
        with Image.open(tmp_path / "run.png") as image:
            assert np.asarray(image.convert("L")).std() > 5, "something is to be seen"
        with pytest.raises(ValueError, match="ending"):
            film.save(plant, tmp_path / "run.mp4")
