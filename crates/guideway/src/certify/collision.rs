//! Is a path free of collision? Samples, and a proof for what lies between them.

use super::ground::{Ground, hull, set};
use crate::Point;
use crate::path::{Path, Planar};
use crate::query::Query;
use crate::world::shape::{distance, wrap};
use crate::world::{Corners, Footprint};
use serde::Serialize;

/// Contact is told from penetration up to this distance, m.
const TOUCH: f64 = 1e-9;
/// Most samples along a path; the step grows beyond.
const MOST: f64 = 1e6;
/// A stretch between two samples is halved no more often than this.
const DEPTH: u32 = 12;

/// What the checker found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Collision {
    /// Nothing comes nearer than the clearance that the query asks for (to 1e-9 m), on samples and between them, and the reference point stays on the map.
    pub ok: bool,
    /// Smallest distance from the footprint to an obstacle that was seen, m; negative in a collision, infinite without obstacles. The samples are
    /// `step` apart (and closer around the smallest), so the true minimum is lower by at most half of that.
    pub min_clearance: f64,
    /// Where the reference point is then, m.
    pub worst: Point,
    /// Distance of samples along the path, m.
    pub step: f64,
    /// Places looked at.
    pub samples: u64,
}

/// Checks `path` for the footprint and the clearance of `query` against its static world.
///
/// The footprint turns with the path; at corners, and at the ends where a heading is asked for, it turns in place and its circumscribed disc has to fit.
/// `step` in m; `None`: a tenth of a cell, at most 0.01 m, but no more than a million samples. Between two samples the distance changes by no more
/// than the way of the fastest point of the footprint; where that proves nothing, the hull of both poses is tested against every obstacle near,
/// with its distance from the curve taken into account, and halved until it decides.
pub fn collision(path: &Path, query: &Query, step: Option<f64>) -> Collision {
    let length = path.length();
    let wanted = step.filter(|s| *s > 0.0).unwrap_or_else(|| (query.world.resolution() / 10.0).min(0.01));
    let n = (length / wanted).ceil().clamp(1.0, MOST);
    let mut check = Check::new(query, path);
    let pace = length / n;
    let mut joints = path.joints();
    joints.retain(|s| *s > 0.0 && *s < length);
    let mut next = joints.into_iter().peekable();
    let mut before = check.visit(0.0, path.planar(0.0));
    for i in 1..=n as u64 {
        let s = if i as f64 == n { length } else { i as f64 * pace };
        // Corners are samples too, so that every stretch is smooth.
        while let Some(joint) = next.next_if(|j| *j < s) {
            before = check.advance(&before, joint);
        }
        before = check.advance(&before, s);
        if check.lost {
            break;
        }
    }
    check.turns();
    check.refine(pace);
    Collision { ok: !check.bad && !check.lost, min_clearance: check.best, worst: check.worst, step: pace, samples: check.samples }
}

/// Checks what the query promises beyond its footprint and clearance: for long loads the half-width and the security marking, a disc around the
/// reference point. `None` where nothing more is promised; distances are those of the reference point. `step` as in [`collision`].
pub fn marking(path: &Path, query: &Query, step: Option<f64>) -> Option<Collision> {
    let radius = query.radius();
    if radius <= query.footprint.circumscribed() + query.clearance {
        return None;
    }
    let load = Query { footprint: Footprint::Disc(radius), clearance: 0.0, ..query.clone() };
    let found = collision(path, &load, step);
    Some(Collision { min_clearance: found.min_clearance + radius, ..found })
}

/// A sample: where, and how far from obstacles (or at least that far).
struct Sample {
    s: f64,
    place: Planar,
    gap: f64,
}

struct Check<'a> {
    ground: Ground<'a>,
    path: &'a Path,
    query: &'a Query,
    /// Corners of the footprint in its own frame; one point for a disc.
    outline: Vec<Point>,
    /// Radius around `outline`.
    radius: f64,
    /// How far a point of the footprint is from the reference point, at most.
    reach: f64,
    /// A point robot: the cells it touches decide, not a distance.
    point: bool,
    best: f64,
    worst: Point,
    /// Arc length of the sample with the least distance, m.
    at: f64,
    samples: u64,
    bad: bool,
    lost: bool,
    /// For a point robot: where it last was between grid lines, and the pinched corner it came to since.
    side: Option<Point>,
    pinch: Option<(Point, f64)>,
}

impl<'a> Check<'a> {
    fn new(query: &'a Query, path: &'a Path) -> Self {
        let (outline, radius) = match (&query.footprint, query.footprint.corners()) {
            (Footprint::Disc(r), _) => (vec![[0.0; 2]], *r),
            (_, corners) => (corners.unwrap_or_default(), 0.0),
        };
        let reach = query.footprint.circumscribed();
        let point = reach + query.clearance <= 2.0 * TOUCH;
        let start = path.point(0);
        Self {
            ground: Ground::new(&query.world),
            path,
            query,
            outline,
            radius,
            reach,
            point,
            best: f64::INFINITY,
            worst: start,
            at: 0.0,
            samples: 0,
            bad: false,
            lost: false,
            side: None,
            pinch: None,
        }
    }

    /// The footprint at a place.
    fn body(&self, place: &Planar) -> Vec<Point> {
        let (sin, cos) = place.heading.sin_cos();
        let [x, y] = place.point;
        self.outline.iter().map(|p| [x + cos * p[0] - sin * p[1], y + sin * p[0] + cos * p[1]]).collect()
    }

    /// Distance of a body from the obstacles where that is below `cap`.
    fn gap(&self, body: &[Point], cap: f64) -> f64 {
        let cap = cap + self.radius;
        if cap < 1e9 {
            return self.ground.gap(body, cap) - self.radius;
        }
        // Nothing is known yet: windows that grow, up to the whole world.
        let [x0, y0, x1, y1] = self.query.world.bounds();
        let whole = (x1 - x0).hypot(y1 - y0) + self.reach;
        let mut window = 16.0 * self.query.world.resolution() + self.radius;
        while window < whole {
            let gap = self.ground.gap(body, window);
            if gap < window {
                return gap - self.radius;
            }
            window *= 4.0;
        }
        self.ground.gap(body, f64::INFINITY) - self.radius
    }

    /// Looks at one place.
    fn visit(&mut self, s: f64, place: Planar) -> Sample {
        self.samples += 1;
        if !self.ground.holds(place.point, TOUCH) {
            self.lost = true;
        }
        // Distances matter below the least so far, and around what is needed.
        let cap = self.best.max(self.query.clearance + 0.02 + 2.0 * self.query.world.resolution());
        let mut gap = if let [_] = self.outline[..] { self.gap(&[place.point], cap) } else { self.outline_gap(&place, cap) };
        if self.point && gap <= TOUCH && self.ground.engulfs(place.point, TOUCH) {
            gap = -self.ground.depth(place.point).max(2.0 * TOUCH);
        }
        if gap < self.best {
            self.at = s;
        }
        self.note(gap, place.point);
        self.bad |= gap < self.query.clearance - TOUCH;
        Sample { s, place, gap }
    }

    fn outline_gap(&self, place: &Planar, cap: f64) -> f64 {
        let around = self.gap(&[place.point], cap + self.reach) - self.reach;
        if around >= cap { around } else { self.gap(&self.body(place), cap) }
    }

    fn note(&mut self, gap: f64, at: Point) {
        if gap < self.best {
            (self.best, self.worst) = (gap, at);
        }
    }

    /// Goes on from a sample to arc length `s` and proves what lies between.
    fn advance(&mut self, from: &Sample, s: f64) -> Sample {
        let to = self.visit(s, self.path.planar(s));
        self.between(from, &to, 0);
        to
    }

    fn between(&mut self, a: &Sample, b: &Sample, depth: u32) {
        let way = b.s - a.s;
        if way <= 0.0 || self.bad {
            return;
        }
        let middle = self.path.planar(0.5 * (a.s + b.s));
        // At the end of a piece the heading is already that of the next one.
        let end = self.path.planar(b.s - 1e-6 * way);
        let bend = if self.path.degree() > 1 {
            1.5 * way * [a.place, middle, end].map(|p| p.curvature.abs()).iter().fold(0.0, |m, k| k.max(m))
        } else {
            0.0
        };
        let turn = bend.max(wrap(end.heading - a.place.heading).abs());
        let swing = if self.outline.len() > 1 { self.reach * turn } else { 0.0 };
        if 0.5 * (a.gap + b.gap - way - swing) > self.query.clearance + TOUCH {
            return;
        }
        // The hull of both poses misses the curve by no more than the sagitta of the reference point and of the turning corners.
        let chord = [0, 1].map(|k| 0.5 * (a.place.point[k] + b.place.point[k]));
        let bulge = if self.path.degree() > 1 { (2.0 * distance(middle.point, chord)).max(bend * way / 8.0) } else { 0.0 };
        let slack = bulge + swing * turn / 8.0;
        let kept = (self.side, self.pinch);
        let free =
            if self.point { self.slide(a.place.point, b.place.point, slack) } else { self.swept(a, Planar { point: b.place.point, ..end }, slack) };
        match free {
            Some(true) => {}
            None if depth < DEPTH => {
                (self.side, self.pinch) = kept;
                let half = self.visit(0.5 * (a.s + b.s), middle);
                self.between(a, &half, depth + 1);
                self.between(&half, b, depth + 1);
            }
            _ => self.bad = true,
        }
    }

    /// Does the hull of two poses stay clear? `None`: undecided.
    fn swept(&mut self, a: &Sample, end: Planar, slack: f64) -> Option<bool> {
        let needed = self.query.clearance;
        let cap = needed + slack + TOUCH;
        let gap = if let [_] = self.outline[..] {
            self.gap(&[a.place.point, end.point], cap)
        } else {
            self.gap(&hull([self.body(&a.place), self.body(&end)].concat()), cap)
        };
        if slack <= TOUCH && gap < cap {
            self.note(gap, a.place.point);
        }
        if gap >= needed + slack || (slack <= TOUCH && gap >= needed - TOUCH) {
            Some(true)
        } else if gap < needed - slack - TOUCH {
            Some(false)
        } else {
            None
        }
    }

    /// May a point slide along the chord? It must not enter the blocked cells, nor pass between two that meet at a corner.
    fn slide(&mut self, a: Point, b: Point, slack: f64) -> Option<bool> {
        if slack > TOUCH {
            return (self.ground.gap(&[a, b], 2.0 * slack) > slack).then_some(true);
        }
        if self.ground.shapes_gap(&[a, b], TOUCH) < -TOUCH {
            return Some(false);
        }
        let Some(grid) = self.ground.grid else { return Some(true) };
        let (p, q) = (grid.to_cells(a), grid.to_cells(b));
        let eps = TOUCH / grid.resolution();
        let mut cuts = vec![0.0, 1.0];
        for k in 0..2 {
            let (low, high) = (p[k].min(q[k]), p[k].max(q[k]));
            cuts.extend((low.ceil() as i64..=high.floor() as i64).map(|v| (v as f64 - p[k]) / (q[k] - p[k])).filter(|t| *t > 0.0 && *t < 1.0));
        }
        cuts.sort_by(f64::total_cmp);
        let at = |t: f64| [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
        for w in cuts.windows(2) {
            self.corner(at(w[0]), eps);
            let middle = at(f64::midpoint(w[0], w[1]));
            // The way between two cuts lies in one cell or on one line.
            let place = grid.to_map(middle);
            if self.ground.engulfs(place, TOUCH) {
                // On the border of the map the point is not deep in the blocked cell, but the outside is no way either.
                self.note(-self.ground.depth(place).max(2.0 * TOUCH), place);
                return Some(false);
            }
            if !self.passes(middle) {
                return Some(false);
            }
            self.side = Some(middle);
        }
        self.corner(at(1.0), eps);
        Some(true)
    }

    /// Remembers a pinched corner that the point has come to (grid frame).
    fn corner(&mut self, q: Point, eps: f64) {
        let (Some(grid), Corners::Touch | Corners::Clear) = (self.ground.grid, self.query.corners) else { return };
        let c = q.map(f64::round);
        if self.pinch.is_some() || (q[0] - c[0]).abs().max((q[1] - c[1]).abs()) > 2.0 * eps {
            return;
        }
        let (x, y, bits) = (c[0] as i64, c[1] as i64, grid.blocked());
        let [sw, se, nw, ne] = [set(bits, x - 1, y - 1), set(bits, x, y - 1), set(bits, x - 1, y), set(bits, x, y)];
        if sw == ne && se == nw && sw != se {
            self.pinch = Some((c, if sw { -1.0 } else { 1.0 }));
        }
    }

    /// Is the point, now at `q`, still on the side of the pinched corner from which it came?
    fn passes(&mut self, q: Point) -> bool {
        let (Some((c, sign)), Some(from)) = (self.pinch.take(), self.side) else { return true };
        let side = |p: Point| (p[0] - c[0]) + sign * (p[1] - c[1]);
        side(from) * side(q) >= 0.0
    }

    /// Looks closer around the nearest sample.
    fn refine(&mut self, mut step: f64) {
        for _ in 0..4 {
            let (from, fine) = (self.at, step / 4.0);
            for i in -4..=4 {
                let s = (from + f64::from(i) * fine).clamp(0.0, self.path.length());
                self.visit(s, self.path.planar(s));
            }
            step = fine;
        }
    }

    /// Turns in place: at corners, and at the ends where a heading is asked for.
    fn turns(&mut self) {
        if self.outline.len() < 2 {
            return;
        }
        let mut places: Vec<f64> = self.path.corners().iter().map(|c| c.s).collect();
        if self.query.start_yaw.is_some_and(|yaw| wrap(yaw - self.path.planar(0.0).heading).abs() > 1e-6) {
            places.push(0.0);
        }
        let length = self.path.length();
        let arriving = self.path.planar(length * (1.0 - 1e-9)).heading;
        if self.query.goal_yaw.is_some_and(|yaw| wrap(yaw - arriving).abs() > 1e-6) {
            places.push(length);
        }
        for s in places {
            let p = self.path.planar(s).point;
            let cap = self.query.clearance + TOUCH;
            let gap = self.gap(&[p], cap + self.reach) - self.reach;
            self.samples += 1;
            if gap < cap {
                self.note(gap, p);
            }
            self.bad |= gap < self.query.clearance - TOUCH;
        }
    }
}
