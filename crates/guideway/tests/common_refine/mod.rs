//! Random smoothing jobs and a checker that shares no code with the library.

use guideway::Point;
use guideway::certify::collision;
use guideway::context::Context;
use guideway::path::Path;
use guideway::plan::planner;
use guideway::query::Query;
use guideway::refine::{Refined, Refiner, Smooth, polyline};
use guideway::world::{Bits, Footprint, Grid, Shape, World};
use std::sync::Arc;

/// splitmix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }
    pub fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n)) as u32
    }
}

/// A map as the checker sees it.
pub struct Map {
    pub cells: Vec<Vec<bool>>,
    pub resolution: f64,
    pub origin: [f64; 3],
    pub discs: Vec<(Point, f64)>,
}

impl Map {
    /// Single cells at a density, or rectangles; any resolution, origin and yaw.
    pub fn random(rng: &mut Random, largest: u32) -> Self {
        let (w, h) = (6 + rng.below(largest), 6 + rng.below(largest));
        let mut cells = vec![vec![false; w as usize]; h as usize];
        if rng.below(2) == 0 {
            let density = rng.between(0.02, 0.4);
            cells.iter_mut().flatten().for_each(|c| *c = rng.unit() < density);
        } else {
            for _ in 0..2 + rng.below(w * h / 20) {
                let (x, y, a, b) = (rng.below(w), rng.below(h), 1 + rng.below(5), 1 + rng.below(5));
                for row in cells.iter_mut().skip(y as usize).take(b as usize) {
                    row.iter_mut().skip(x as usize).take(a as usize).for_each(|c| *c = true);
                }
            }
        }
        let resolution = [0.05, 0.1, 1.0, 2.5][rng.below(4) as usize];
        let yaw = if rng.below(2) == 0 { 0.0 } else { rng.between(-3.2, 3.2) };
        Self { cells, resolution, origin: [rng.between(-50.0, 50.0), rng.between(-50.0, 50.0), yaw], discs: Vec::new() }
    }

    pub fn world(&self) -> World {
        let (w, h) = (self.cells[0].len() as u32, self.cells.len() as u32);
        let mut blocked = Bits::new(w, h);
        for y in 0..h {
            for x in 0..w {
                blocked.set(x, y, self.cells[y as usize][x as usize]);
            }
        }
        let shapes = self.discs.iter().map(|(c, r)| Shape::disc(*c, *r).unwrap()).collect();
        World::from_grid(Grid::new(blocked, None, self.resolution, self.origin).unwrap()).with_shapes(shapes)
    }

    fn blocked(&self, x: i64, y: i64) -> bool {
        x >= 0 && y >= 0 && self.cells.get(y as usize).and_then(|row| row.get(x as usize)).copied().unwrap_or(false)
    }

    fn local(&self, p: Point) -> Point {
        let (s, c) = self.origin[2].sin_cos();
        let (dx, dy) = (p[0] - self.origin[0], p[1] - self.origin[1]);
        [(c * dx + s * dy) / self.resolution, (c * dy - s * dx) / self.resolution]
    }

    pub fn to_map(&self, q: Point) -> Point {
        let (s, c) = self.origin[2].sin_cos();
        let (dx, dy) = (q[0] * self.resolution, q[1] * self.resolution);
        [self.origin[0] + c * dx - s * dy, self.origin[1] + s * dx + c * dy]
    }

    /// Distance from `p` to the nearest obstacle within `reach` (m), m; negative inside a cell.
    fn distance(&self, p: Point, reach: f64) -> f64 {
        let q = self.local(p);
        let k = (reach / self.resolution).ceil() as i64 + 1;
        let (cx, cy) = (q[0].floor() as i64, q[1].floor() as i64);
        let mut best = f64::INFINITY;
        for y in cy - k..=cy + k {
            for x in cx - k..=cx + k {
                if self.blocked(x, y) {
                    let (dx, dy) = ((q[0] - x as f64 - 0.5).abs() - 0.5, (q[1] - y as f64 - 0.5).abs() - 0.5);
                    let d = if dx < 0.0 && dy < 0.0 { dx.max(dy) } else { dx.max(0.0).hypot(dy.max(0.0)) };
                    best = best.min(d * self.resolution);
                }
            }
        }
        self.discs.iter().map(|(c, r)| (p[0] - c[0]).hypot(p[1] - c[1]) - r).fold(best, f64::min)
    }

    /// First place along the sampled way that is nearer than `radius` to an obstacle, outside the map, or between two cells that meet at a corner.
    pub fn collision(&self, way: impl Iterator<Item = Point>, radius: f64) -> Option<Point> {
        let (w, h) = (self.cells[0].len() as f64, self.cells.len() as f64);
        let mut last: Option<Point> = None;
        for p in way {
            let q = self.local(p);
            let outside = !(q[0] > -1e-6 && q[1] > -1e-6 && q[0] < w + 1e-6 && q[1] < h + 1e-6);
            let near = self.distance(p, radius);
            if outside || near.is_nan() || near < radius - 1e-8 || last.is_some_and(|l| self.squeezes(l, q)) {
                return Some(p);
            }
            last = Some(q);
        }
        None
    }

    /// Does a short step go from one free cell to the diagonal one between two blocked cells?
    fn squeezes(&self, a: Point, b: Point) -> bool {
        let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(|v| v.floor() as i64);
        (ax - bx).abs() == 1 && (ay - by).abs() == 1 && self.blocked(ax, by) && self.blocked(bx, ay)
    }
}

/// Shortest path over corners of cells (pushed out for a robot with a radius), by brute force: taut, as an exact planner returns it.
pub fn taut(map: &Map, query: &Query) -> Option<Vec<Point>> {
    let (r, world) = (query.radius(), &query.world);
    let mut nodes = vec![query.start, query.goal];
    let (w, h) = (map.cells[0].len() as i64, map.cells.len() as i64);
    for y in 0..=h {
        for x in 0..=w {
            let around = [(x - 1, y - 1), (x, y - 1), (x - 1, y), (x, y)].map(|(i, j)| map.blocked(i, j));
            let pinch = around == [true, false, false, true] || around == [false, true, true, false];
            if pinch || !around.contains(&true) || !around.contains(&false) {
                continue;
            }
            let reach = r / map.resolution / (std::f64::consts::PI / 8.0).cos();
            let directions = if r > 0.0 { 8 } else { 1 };
            for k in 0..directions {
                let (s, c) = (std::f64::consts::FRAC_PI_4 * (f64::from(k) + 0.5)).sin_cos();
                let p = map.to_map([x as f64 + reach * c, y as f64 + reach * s]);
                if world.segment_free(p, p, r) {
                    nodes.push(p);
                }
            }
        }
    }
    let mut cost = vec![f64::INFINITY; nodes.len()];
    let (mut from, mut done) = (vec![0; nodes.len()], vec![false; nodes.len()]);
    cost[0] = 0.0;
    while let Some(i) = (0..nodes.len()).filter(|&i| !done[i] && cost[i] < f64::INFINITY).min_by(|&a, &b| cost[a].total_cmp(&cost[b])) {
        done[i] = true;
        if i == 1 {
            break;
        }
        for j in 1..nodes.len() {
            let d = cost[i] + (nodes[i][0] - nodes[j][0]).hypot(nodes[i][1] - nodes[j][1]);
            if !done[j] && d < cost[j] && world.segment_free(nodes[i], nodes[j], r) {
                (cost[j], from[j]) = (d, i);
            }
        }
    }
    (cost[1] < f64::INFINITY).then(|| {
        let mut points = vec![nodes[1]];
        let mut i = 1;
        while i != 0 {
            i = from[i];
            points.push(nodes[i]);
        }
        points.reverse();
        points
    })
}

/// One random job: a map, a query (sometimes with a via point), a raw path, the smoothed path, and every check. `None` if the query has no path.
pub fn job(seed: u64) -> Option<Outcome> {
    let mut rng = Random(seed);
    let exact = rng.below(3) > 0;
    let mut map = Map::random(&mut rng, if exact { 14 } else { 40 });
    if rng.below(4) == 0 {
        for _ in 0..=rng.below(6) {
            let c = map.to_map([rng.between(0.0, map.cells[0].len() as f64), rng.between(0.0, map.cells.len() as f64)]);
            map.discs.push((c, rng.between(0.1, 1.5) * map.resolution));
        }
    }
    let radius = map.resolution * [0.0, 0.0, rng.between(0.01, 0.6), rng.between(0.01, 1.6)][rng.below(4) as usize];
    let world = Arc::new(map.world());
    let mut place = || {
        (0..50)
            .map(|_| map.to_map([rng.between(0.0, map.cells[0].len() as f64), rng.between(0.0, map.cells.len() as f64)]))
            .find(|p| world.clearance(*p) >= radius + 1e-6)
    };
    let (start, via, goal) = (place()?, place()?, place()?);
    let mut query = Query::new(Arc::clone(&world), start, goal);
    query.footprint = Footprint::Disc(radius);
    if rng.below(4) == 0 {
        query.via.push(via);
    }
    let raw = raw(&map, &query, exact)?;
    if !raw.windows(2).all(|w| world.segment_free(w[0], w[1], radius)) {
        return None; // a lattice step may touch; the promise is about free paths
    }
    let smooth = Smooth { max_curvature: (rng.below(3) == 0).then(|| rng.between(0.1, 3.0) / map.resolution), ..Smooth::default() };
    let refined = smooth.refine(&Path::polyline(&raw), &query, &mut Context::new(seed)).unwrap();
    check(&map, &query, &refined, seed);
    Some(Outcome { raw: Path::polyline(&raw).length(), smooth: refined.path.length(), corners: refined.path.corners().len(), bends: raw.len() - 2 })
}

/// What a job gave.
pub struct Outcome {
    /// m.
    pub raw: f64,
    /// m.
    pub smooth: f64,
    pub corners: usize,
    pub bends: usize,
}

fn raw(map: &Map, query: &Query, exact: bool) -> Option<Vec<Point>> {
    let mut points = vec![query.start];
    for leg in query.stops().windows(2) {
        let mut part = Query::new(Arc::clone(&query.world), leg[0], leg[1]);
        part.footprint = query.footprint.clone();
        let way = if exact && map.discs.is_empty() {
            taut(map, &part)?
        } else {
            planner("astar", serde_json::Value::Null).unwrap().plan(&part, &mut Context::new(0)).ok()?.path.points()
        };
        points.extend(&way[1..]);
    }
    Some(points)
}

fn check(map: &Map, query: &Query, refined: &Refined, seed: u64) {
    let path = &refined.path;
    let length = path.length();
    assert!(length.is_finite() && path.control().iter().all(|v| v.is_finite()), "seed {seed}: not finite");
    assert_eq!(path.ends(), [query.start, query.goal], "seed {seed}: not anchored");
    for via in &query.via {
        let d = path.project(*via, 0.0, length).1.abs();
        assert!(d <= 1e-9 * (1.0 + length + via[0].abs() + via[1].abs()), "seed {seed}: {d} m from the via point");
    }
    let n = (length / (map.resolution * 0.01)).ceil().clamp(1.0, 40_000.0);
    let samples = (0..=n as u32).map(|i| path.planar(length * f64::from(i) / n).point);
    if let Some(p) = map.collision(samples, query.radius()) {
        panic!("seed {seed}: collision at {p:?}, {} m", map.distance(p, query.radius()));
    }
    let certificate = collision(path, query, None);
    assert!(certificate.ok, "seed {seed}: {certificate:?}");
    let chords = polyline(path, query);
    let along = chords.windows(2).flat_map(|w| (0..=10).map(move |i| [0, 1].map(|d| w[0][d] + (w[1][d] - w[0][d]) * f64::from(i) / 10.0)));
    if let Some(p) = map.collision(along, query.radius()) {
        panic!("seed {seed}: a chord collides at {p:?}, {} m", map.distance(p, query.radius()));
    }
}
