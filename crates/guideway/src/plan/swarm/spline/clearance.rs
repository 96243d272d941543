//! How near a curve comes to obstacles, exact up to a tolerance: no holes between samples.
//!
//! Between two nodes the curve stays within `sag` of its chord (its second derivative is bounded), so the distance from the chord less `sag` is a lower
//! bound; where that does not settle the matter the stretch is halved, which quarters `sag`.

use super::samples::{NODES, Piece, Row, STEP, Scratch};
use crate::Point;
use crate::query::Query;
use crate::world::{ClearanceField, Grid, Shape, World};
use std::sync::Arc;

/// A curve is called free only if it keeps that much more than what is asked for, m, so that no certificate refuses it.
const MARGIN: f64 = 1e-7;
/// The least distance is known that exactly where it matters, m; a share of what is in hand elsewhere.
const EXACT: (f64, f64) = (1e-10, 1e-6);
/// Robots smaller than that are points for certificates, m.
const POINT: f64 = 2e-9;
/// A stretch is halved no more often than that.
const DEPTH: u32 = 32;
/// Fields of maps with more cells than that are not built for a plan, only used.
const FIELD: u64 = 1 << 24;

/// What a curve must keep away from.
#[derive(Debug, Clone)]
pub(super) struct Obstacles {
    world: Arc<World>,
    /// Middle and radius, m.
    discs: Vec<[f64; 3]>,
    /// Polygons in discs.
    polygons: Vec<(Shape, [f64; 3])>,
    /// On maps everything is asked of the world.
    map: bool,
    field: Option<Arc<ClearanceField>>,
    /// Distance to keep, m, and the one from which a curve is called free.
    pub needed: f64,
    floor: f64,
    /// What a lack of distance is measured in, m.
    scale: f64,
    /// The world's sides: outward unit normals and how far they are out, m.
    sides: [([f64; 2], f64); 4],
}

/// What was found about a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    /// Least distance to an obstacle, m; infinite without obstacles. Where it is below what is needed only the samples may count.
    pub clearance: f64,
    /// 0 if the curve is free; else the relative lack of distance at the worst place and on average, and how far it leaves the world.
    pub violation: f64,
}

/// Something that distances are measured to.
trait Near {
    /// Distance of a point where that is below `cap`, else anything from `cap` up, m.
    fn point(&self, p: Point, cap: f64) -> f64;
    /// No more than the distance of the points of a segment, and all of it where that is below `cap`, m.
    fn segment(&self, a: Point, b: Point, cap: f64) -> f64;
}

struct Disc([f64; 3]);

impl Near for Disc {
    #[inline]
    fn point(&self, p: Point, _: f64) -> f64 {
        apart(p, self.0)
    }
    #[inline]
    fn segment(&self, a: Point, b: Point, _: f64) -> f64 {
        let [x, y, r] = self.0;
        let (e, v) = ([b[0] - a[0], b[1] - a[1]], [x - a[0], y - a[1]]);
        let square = e[0] * e[0] + e[1] * e[1];
        let t = if square > 0.0 { ((v[0] * e[0] + v[1] * e[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        apart([v[0] - t * e[0], v[1] - t * e[1]], [0.0, 0.0, r])
    }
}

impl Near for Shape {
    fn point(&self, p: Point, _: f64) -> f64 {
        self.distance(p)
    }
    fn segment(&self, a: Point, b: Point, _: f64) -> f64 {
        self.segment_distance(a, b)
    }
}

impl Near for World {
    fn point(&self, p: Point, cap: f64) -> f64 {
        self.clearance_within(p, cap)
    }
    fn segment(&self, a: Point, b: Point, cap: f64) -> f64 {
        self.segment_clearance_within(a, b, cap)
    }
}

#[inline]
fn apart(p: Point, [x, y, r]: [f64; 3]) -> f64 {
    let (dx, dy) = (p[0] - x, p[1] - y);
    (dx * dx + dy * dy).sqrt() - r
}

impl Obstacles {
    pub fn new(query: &Query) -> Self {
        let world = Arc::clone(&query.world);
        let map = world.grid().is_some();
        let (mut discs, mut polygons) = (Vec::new(), Vec::new());
        for shape in world.shapes().iter().filter(|_| !map) {
            match shape {
                Shape::Disc { center, radius } => discs.push([center[0], center[1], *radius]),
                Shape::Polygon { points } => polygons.push((shape.clone(), around(points))),
            }
        }
        let needed = query.radius();
        let floor = if needed <= POINT {
            MARGIN
        } else {
            // A stop that touches leaves no margin.
            let stops = query.stops().into_iter().map(|p| world.clearance_within(p, needed + 2.0 * MARGIN) - 3.0 * EXACT.0);
            stops.fold(needed + MARGIN, f64::min)
        };
        let scale = if needed <= POINT { world.resolution() } else { needed };
        let [w, h] = world.cells().map(u64::from);
        let field = (map && w * h <= FIELD).then(|| world.clearance_field());
        let sides = sides(&world);
        Self { world, discs, polygons, map, field, needed, floor, scale, sides }
    }

    /// Judges the curve in the scratch.
    pub fn judge(&self, scratch: &mut Scratch) -> Found {
        let clearance = if self.map { self.least_on_map(scratch) } else { self.least_in_scene(scratch) };
        let mut violation = self.outside(scratch) / self.scale;
        if clearance < self.floor {
            violation += (self.floor - clearance) / self.scale + self.lack(scratch);
        }
        Found { clearance, violation }
    }

    fn tolerance(&self, best: f64) -> f64 {
        EXACT.0 + EXACT.1 * (best - self.floor).max(0.0)
    }

    fn least_in_scene(&self, scratch: &mut Scratch) -> f64 {
        scratch.near.clear();
        let mut best = f64::INFINITY;
        for (k, piece) in scratch.pieces.iter().enumerate() {
            for (i, disc) in self.discs.iter().enumerate() {
                let far = apart(piece.middle, *disc) - piece.radius;
                if far < best.max(self.needed) {
                    let least = nearest_node(piece, *disc);
                    best = best.min(least);
                    scratch.near.push((k, i, least));
                }
            }
            for (i, (shape, disc)) in self.polygons.iter().enumerate() {
                if apart(piece.middle, *disc) - piece.radius < best.max(self.needed) {
                    let least = (0..NODES).map(|j| self.at_polygon(piece.node(j), shape, *disc, best)).fold(f64::INFINITY, f64::min);
                    best = best.min(least);
                    scratch.near.push((k, self.discs.len() + i, least));
                }
            }
        }
        for &(k, i, least) in &scratch.near {
            let piece = &scratch.pieces[k];
            // From a node to the farthest point of its stretches.
            if best < self.floor || least - reach(piece) >= best {
                continue;
            }
            match self.discs.get(i) {
                Some(disc) => self.close(piece, &Disc(*disc), &mut best),
                None => self.close(piece, &self.polygons[i - self.discs.len()].0, &mut best),
            }
        }
        best
    }

    fn at_polygon(&self, p: Point, shape: &Shape, disc: [f64; 3], best: f64) -> f64 {
        let far = apart(p, disc);
        if far >= best.max(self.needed) { far } else { shape.distance(p) }
    }

    /// Lowers `best` to the least distance of a piece from an obstacle, if that is less.
    fn close<N: Near>(&self, piece: &Piece, near: &N, best: &mut f64) {
        for j in 0..NODES - 1 {
            let (a, b) = (piece.node(j), piece.node(j + 1));
            self.halve(piece, near, ([STEP * j as f64, STEP * (j + 1) as f64], [a, b], piece.sag), best, 0);
        }
    }

    fn halve<N: Near>(&self, piece: &Piece, near: &N, (t, ends, sag): ([f64; 2], [Point; 2], f64), best: &mut f64, depth: u32) {
        let goal = *best - self.tolerance(*best);
        if *best < self.floor || depth >= DEPTH || near.segment(ends[0], ends[1], goal + sag) - sag >= goal {
            return;
        }
        let middle = 0.5 * (t[0] + t[1]);
        let p = piece.at(middle);
        *best = best.min(near.point(p, *best));
        self.halve(piece, near, ([t[0], middle], [ends[0], p], 0.25 * sag), best, depth + 1);
        self.halve(piece, near, ([middle, t[1]], [p, ends[1]], 0.25 * sag), best, depth + 1);
    }

    fn least_on_map(&self, scratch: &mut Scratch) -> f64 {
        scratch.bounds.resize(scratch.pieces.len(), [0.0; NODES]);
        let (mut lowest, mut at) = (f64::INFINITY, (0, 0));
        for (k, (piece, bounds)) in scratch.pieces.iter().zip(&mut scratch.bounds).enumerate() {
            for (j, bound) in bounds.iter_mut().enumerate() {
                *bound = self.quick(piece.node(j));
                if *bound < lowest {
                    (lowest, at) = (*bound, (k, j));
                }
            }
        }
        let mut best = self.world.point(scratch.pieces[at.0].node(at.1), f64::INFINITY);
        if best == f64::INFINITY {
            return best;
        }
        for (piece, bounds) in scratch.pieces.iter().zip(&mut scratch.bounds) {
            for (j, bound) in bounds.iter_mut().enumerate() {
                if best >= self.floor && *bound < best {
                    *bound = self.world.point(piece.node(j), best);
                    best = best.min(*bound);
                }
            }
        }
        for (piece, bounds) in scratch.pieces.iter().zip(&scratch.bounds) {
            for j in 0..NODES - 1 {
                let ends = [piece.node(j), piece.node(j + 1)];
                let chord = apart(ends[0], [ends[1][0], ends[1][1], 0.0]);
                // Distances change by no more than the way.
                if best >= self.floor && 0.5 * (bounds[j] + bounds[j + 1] - chord) - piece.sag < best {
                    self.halve(piece, &*self.world, ([STEP * j as f64, STEP * (j + 1) as f64], ends, piece.sag), &mut best, 0);
                }
            }
        }
        best
    }

    /// A lower bound of the distance at a point outside of obstacles.
    fn quick(&self, p: Point) -> f64 {
        let (Some(field), Some(grid)) = (&self.field, self.world.grid()) else { return f64::NEG_INFINITY };
        let q = grid.to_cells(p);
        let Some(cell) = grid.cell_of(q) else { return f64::NEG_INFINITY };
        let off = apart(q, [f64::from(cell[0]) + 0.5, f64::from(cell[1]) + 0.5, 0.0]) * grid.resolution();
        field.at(cell) - off - 1e-9
    }

    /// Mean relative lack of distance at the nodes.
    fn lack(&self, scratch: &mut Scratch) -> f64 {
        let (pieces, rows) = (&scratch.pieces, &mut scratch.bounds);
        let mut sum = 0.0;
        if self.map {
            for (piece, row) in pieces.iter().zip(rows.iter()) {
                for j in (0..NODES).filter(|&j| row[j] < self.floor) {
                    sum += (self.floor - self.world.point(piece.node(j), self.floor)).max(0.0);
                }
            }
        } else {
            let mut worst: Row = [0.0; NODES];
            for (n, &(k, i, least)) in scratch.near.iter().enumerate() {
                let piece = &pieces[k];
                if least < self.floor {
                    for (j, w) in worst.iter_mut().enumerate() {
                        let p = piece.node(j);
                        let distance = self.discs.get(i).map_or_else(|| self.polygons[i - self.discs.len()].0.distance(p), |disc| apart(p, *disc));
                        *w = w.max(self.floor - distance);
                    }
                }
                if scratch.near.get(n + 1).is_none_or(|next| next.0 != k) {
                    sum += worst.iter().sum::<f64>();
                    worst = [0.0; NODES];
                }
            }
        }
        sum / (self.scale * (NODES * pieces.len()) as f64)
    }

    /// How far the curve leaves the world, m; 0 if it does not.
    fn outside(&self, scratch: &Scratch) -> f64 {
        let over = |p: &Point| self.sides.iter().map(|(n, out)| n[0] * p[0] + n[1] * p[1] - out).fold(f64::NEG_INFINITY, f64::max);
        // The curve lies in the hull of its control points.
        if scratch.control.iter().all(|p| over(p) <= EXACT.0) {
            return 0.0;
        }
        let most = scratch.pieces.iter().flat_map(|piece| self.sides.iter().map(|side| farthest(piece, *side))).fold(0.0, f64::max);
        if most <= EXACT.0 { 0.0 } else { most }
    }
}

/// How far a piece is beyond a side, m: a cubic polynomial, largest at an end or where its derivative vanishes.
fn farthest(piece: &Piece, (n, out): ([f64; 2], f64)) -> f64 {
    let c = [0, 1, 2, 3].map(|m| n[0] * piece.power[0][m] + n[1] * piece.power[1][m]);
    let at = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3])) - out;
    let mut most = at(0.0).max(at(1.0));
    let (a, b, d) = (3.0 * c[3], c[2], c[1]);
    let root = b * b - a * d;
    if root >= 0.0 {
        let q = -(b + root.sqrt().copysign(b));
        for t in [q / a, d / q].into_iter().filter(|t| (0.0..=1.0).contains(t)) {
            most = most.max(at(t));
        }
    }
    most
}

/// Least distance of the nodes of a piece from a disc.
#[inline]
fn nearest_node(piece: &Piece, [x, y, r]: [f64; 3]) -> f64 {
    let mut square: Row = [0.0; NODES];
    for (square, (px, py)) in square.iter_mut().zip(piece.x.iter().zip(&piece.y)) {
        let (dx, dy) = (px - x, py - y);
        *square = dx * dx + dy * dy;
    }
    square.iter().fold(f64::INFINITY, |m, v| if *v < m { *v } else { m }).sqrt() - r
}

/// No point of a piece is farther than that from a node, m.
fn reach(piece: &Piece) -> f64 {
    let longest = (0..NODES - 1).map(|j| {
        let (dx, dy) = (piece.x[j + 1] - piece.x[j], piece.y[j + 1] - piece.y[j]);
        dx * dx + dy * dy
    });
    0.5 * longest.fold(0.0, f64::max).sqrt() + piece.sag
}

/// A disc around a polygon.
fn around(points: &[Point]) -> [f64; 3] {
    let n = points.len() as f64;
    let middle = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / n);
    let radius = points.iter().map(|p| apart(*p, [middle[0], middle[1], 0.0])).fold(0.0, f64::max);
    [middle[0], middle[1], radius]
}

fn sides(world: &World) -> [([f64; 2], f64); 4] {
    let [x0, y0, x1, y1] = world.bounds();
    let corners = world.grid().map_or([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], |grid: &Grid| {
        let (w, h) = (f64::from(grid.width()), f64::from(grid.height()));
        [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|q| grid.to_map(q))
    });
    [0, 1, 2, 3].map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let length = apart(a, [b[0], b[1], 0.0]);
        let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        (normal, normal[0] * a[0] + normal[1] * a[1])
    })
}
