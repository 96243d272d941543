//! A candidate's curve at evenly spaced parameters of each piece, as rows of numbers that loops run through without branches.

use super::basis::Basis;
use crate::Point;

/// Nodes of a piece, both ends among them.
pub(super) const NODES: usize = 17;
/// Distance of nodes in the parameter of a piece.
pub(super) const STEP: f64 = 1.0 / (NODES - 1) as f64;

/// One value for each node of a piece.
pub(super) type Row = [f64; NODES];

/// A piece with its nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Coefficients in powers of `t`, x and y.
    pub power: [[f64; 4]; 2],
    pub x: Row,
    pub y: Row,
    /// Speed in `t`, m.
    pub speed: Row,
    /// Signed curvature, 1/m.
    pub curvature: Row,
    /// Between two nodes the curve stays that near to the chord, m.
    pub sag: f64,
    /// Middle and radius of a disc around the piece, m.
    pub middle: Point,
    pub radius: f64,
}

impl Piece {
    const EMPTY: Self = Self {
        power: [[0.0; 4]; 2],
        x: [0.0; NODES],
        y: [0.0; NODES],
        speed: [0.0; NODES],
        curvature: [0.0; NODES],
        sag: 0.0,
        middle: [0.0; 2],
        radius: 0.0,
    };

    pub fn node(&self, j: usize) -> Point {
        [self.x[j], self.y[j]]
    }

    /// The point at `t`.
    pub fn at(&self, t: f64) -> Point {
        [0, 1].map(|d| {
            let c = &self.power[d];
            c[0] + t * (c[1] + t * (c[2] + t * c[3]))
        })
    }

    fn fill(&mut self) {
        let [cx, cy] = self.power;
        for j in 0..NODES {
            let t = STEP * j as f64;
            let (dx, dy) = (cx[1] + t * (2.0 * cx[2] + t * 3.0 * cx[3]), cy[1] + t * (2.0 * cy[2] + t * 3.0 * cy[3]));
            let (ex, ey) = (2.0 * cx[2] + 6.0 * t * cx[3], 2.0 * cy[2] + 6.0 * t * cy[3]);
            self.x[j] = cx[0] + t * (cx[1] + t * (cx[2] + t * cx[3]));
            self.y[j] = cy[0] + t * (cy[1] + t * (cy[2] + t * cy[3]));
            // A cusp has no direction; a speed of a nanometre keeps its numbers finite.
            let square = (dx * dx + dy * dy).max(1e-18);
            let speed = square.sqrt();
            self.speed[j] = speed;
            self.curvature[j] = (dx * ey - dy * ex) / (square * speed);
        }
        // The second derivative is linear in t: its largest size is at an end.
        let second = |t: f64| {
            let (ex, ey) = (2.0 * cx[2] + 6.0 * t * cx[3], 2.0 * cy[2] + 6.0 * t * cy[3]);
            (ex * ex + ey * ey).sqrt()
        };
        self.sag = second(0.0).max(second(1.0)) * STEP * STEP / 8.0;
        self.enclose();
    }

    fn enclose(&mut self) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for j in 0..NODES {
            low = [low[0].min(self.x[j]), low[1].min(self.y[j])];
            high = [high[0].max(self.x[j]), high[1].max(self.y[j])];
        }
        let half = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
        self.middle = [low[0] + half[0], low[1] + half[1]];
        self.radius = (half[0] * half[0] + half[1] * half[1]).sqrt() + self.sag;
    }

    /// Arc length from node `j` to the next one, m: Simpson's rule with the correction by the slopes at both ends, exact to the sixth order.
    pub fn lengths(&self) -> [f64; NODES - 1] {
        let [cx, cy] = self.power;
        let mut slope = [0.0; NODES];
        for (j, (slope, speed)) in slope.iter_mut().zip(&self.speed).enumerate() {
            let t = STEP * j as f64;
            let (dx, dy) = (cx[1] + t * (2.0 * cx[2] + t * 3.0 * cx[3]), cy[1] + t * (2.0 * cy[2] + t * 3.0 * cy[3]));
            let (ex, ey) = (2.0 * cx[2] + 6.0 * t * cx[3], 2.0 * cy[2] + 6.0 * t * cy[3]);
            *slope = (dx * ex + dy * ey) / speed;
        }
        let mut out = [0.0; NODES - 1];
        for j in 0..NODES - 1 {
            let t = STEP * (j as f64 + 0.5);
            let (dx, dy) = (cx[1] + t * (2.0 * cx[2] + t * 3.0 * cx[3]), cy[1] + t * (2.0 * cy[2] + t * 3.0 * cy[3]));
            let plain = STEP / 30.0 * (7.0 * (self.speed[j] + self.speed[j + 1]) + 16.0 * (dx * dx + dy * dy).sqrt());
            // Near a cusp the slope jumps and the correction is none.
            let most = 0.05 * plain;
            out[j] = plain + (STEP * STEP / 60.0 * (slope[j] - slope[j + 1])).clamp(-most, most);
        }
        out
    }
}

impl Piece {
    /// The largest curvature, 1/m: at the nodes, and between them wherever it may exceed `limit` there, until that is settled.
    pub fn sharpest(&self, limit: f64) -> f64 {
        let [cx, cy] = self.power;
        let rates = [8.0 * self.sag / (STEP * STEP), 6.0 * (cx[3] * cx[3] + cy[3] * cy[3]).sqrt()];
        let mut most = self.curvature.iter().fold(0.0f64, |m, k| m.max(k.abs()));
        for j in 0..NODES - 1 {
            let ends = [j, j + 1].map(|i| (self.speed[i], self.curvature[i].abs() * self.speed[i].powi(3)));
            self.bend([STEP * j as f64, STEP], ends, rates, (limit, &mut most));
        }
        most
    }

    /// Speed and cross product of the first two derivatives at `t`.
    fn turning(&self, t: f64) -> (f64, f64) {
        let [cx, cy] = self.power;
        let (dx, dy) = (cx[1] + t * (2.0 * cx[2] + t * 3.0 * cx[3]), cy[1] + t * (2.0 * cy[2] + t * 3.0 * cy[3]));
        let (ex, ey) = (2.0 * cx[2] + 6.0 * t * cx[3], 2.0 * cy[2] + 6.0 * t * cy[3]);
        ((dx * dx + dy * dy).max(1e-18).sqrt(), dx * ey - dy * ex)
    }

    /// Signed curvature at `t`, 1/m.
    pub fn curvature_at(&self, t: f64) -> f64 {
        let (speed, cross) = self.turning(t);
        cross / speed.powi(3)
    }

    /// Looks into a stretch `[from, width]` as long as the curvature in it may exceed the limit. `rates` bound the second and the third derivative.
    fn bend(&self, [from, width]: [f64; 2], ends: [(f64, f64); 2], rates: [f64; 2], (limit, most): (f64, &mut f64)) {
        let slack = 0.5 * width * rates[0];
        let slowest = 0.5 * (ends[0].0 + ends[1].0) - slack;
        let cross = ends[0].1.max(ends[1].1) + 0.5 * width * (ends[0].0.max(ends[1].0) + slack) * rates[1];
        let settled = slowest > 0.0 && cross <= limit * slowest * slowest * slowest;
        if settled || *most > limit || width < 1e-6 {
            return;
        }
        let half = 0.5 * width;
        let middle = self.turning(from + half);
        let middle = (middle.0, middle.1.abs());
        *most = most.max(middle.1 / middle.0.powi(3));
        self.bend([from, half], [ends[0], middle], rates, (limit, most));
        self.bend([from + half, half], [middle, ends[1]], rates, (limit, most));
    }
}

/// What the cost of one candidate after the other is computed in; nothing is allocated for a candidate.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub control: Vec<Point>,
    pub pieces: Vec<Piece>,
    /// Arc length at each node.
    pub places: Vec<Row>,
    /// Lower bounds of the distance at each node.
    pub bounds: Vec<Row>,
    /// Pieces and obstacles that may meet: piece, obstacle, least distance at nodes.
    pub near: Vec<(usize, usize, f64)>,
}

impl Scratch {
    /// Fills the pieces from the control points.
    pub fn sample(&mut self, basis: &Basis) {
        self.pieces.resize(basis.pieces(), Piece::EMPTY);
        for (k, piece) in self.pieces.iter_mut().enumerate() {
            piece.power = basis.piece(k, &self.control);
            piece.fill();
        }
    }

    /// Arc lengths of the nodes; gives back the length, m.
    pub fn measure(&mut self) -> f64 {
        let mut s = 0.0;
        self.places.resize(self.pieces.len(), [0.0; NODES]);
        for (piece, place) in self.pieces.iter().zip(&mut self.places) {
            let lengths = piece.lengths();
            place[0] = s;
            for j in 0..NODES - 1 {
                s += lengths[j];
                place[j + 1] = s;
            }
        }
        s
    }
}
