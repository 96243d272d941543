//! Which way a path passes obstacles: the sequence of rays that it crosses, one ray upwards from a point inside every obstacle.
//!
//! Two paths with the same ends can be deformed into each other among the obstacles exactly if their words, reduced (a crossing and the crossing back next
//! to it cancel), are equal: the words are the fundamental group of the plane without those points, which is free. More than one point in an obstacle, or
//! in several that no robot passes between, does no harm.

use crate::Point;
use crate::world::{Bits, Grid, Shape, World};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Crossings in order: `k + 1` for ray `k` from left to right, `-(k + 1)` from right to left.
pub(in crate::plan) type Word = Vec<i32>;

/// Shares of a shape or cell by which its point lies beside the middle: tangents and arcs of tidy scenes begin and end right above the middle.
const ASIDE: Point = [0.237_1, 0.119_3];

/// Points inside obstacles, each with the ray upwards from it, by `x`.
#[derive(Debug, Clone, Default)]
pub(in crate::plan) struct Rays {
    points: Vec<Point>,
}

/// One point in every obstacle of a world: each shape, and each group of blocked cells that share edges and does not touch the border of the map.
pub(super) fn inside(world: &World) -> Vec<Point> {
    let mut points: Vec<Point> = world.shapes().iter().map(of_shape).collect();
    if let Some(grid) = world.grid() {
        points.extend(islands(grid.blocked()).into_iter().map(|[x, y]| beside(grid, x, y)));
    }
    points
}

fn of_shape(shape: &Shape) -> Point {
    match shape {
        Shape::Disc { center, radius } => [0, 1].map(|k| center[k] + ASIDE[k] * radius),
        Shape::Polygon { points } => {
            let weights: Vec<f64> = (0..points.len()).map(|i| 1.0 + (0.618 * i as f64).fract()).collect();
            let total: f64 = weights.iter().sum();
            [0, 1].map(|k| points.iter().zip(&weights).map(|(p, w)| p[k] * w).sum::<f64>() / total)
        }
    }
}

fn beside(grid: &Grid, x: u32, y: u32) -> Point {
    grid.to_map([f64::from(x) + 0.5 + ASIDE[0], f64::from(y) + 0.5 + ASIDE[1]])
}

/// A cell of each group of set cells that share edges, without the groups at the border.
fn islands(bits: &Bits) -> Vec<[u32; 2]> {
    let mut groups = Groups::default();
    let mut above: Vec<(u32, u32, usize)> = Vec::new();
    for y in 0..bits.height() {
        let mut row: Vec<(u32, u32, usize)> = Vec::new();
        let mut x = 0;
        let mut first = 0;
        while let Some(a) = (x < bits.width()).then(|| bits.first(y, x, bits.width() - 1, true)).flatten() {
            let b = bits.first(y, a, bits.width() - 1, false).unwrap_or(bits.width());
            let edge = y == 0 || y + 1 == bits.height() || a == 0 || b == bits.width();
            let group = groups.add([a, y], edge);
            while first < above.len() && above[first].1 <= a {
                first += 1;
            }
            for run in above[first..].iter().take_while(|run| run.0 < b) {
                groups.join(run.2, group);
            }
            row.push((a, b, group));
            x = b;
        }
        above = row;
    }
    groups.inner()
}

/// Sets that are joined, each with a cell and whether it touches the border.
#[derive(Default)]
struct Groups {
    parent: Vec<usize>,
    cell: Vec<[u32; 2]>,
    edge: Vec<bool>,
}

impl Groups {
    fn add(&mut self, cell: [u32; 2], edge: bool) -> usize {
        self.parent.push(self.parent.len());
        self.cell.push(cell);
        self.edge.push(edge);
        self.parent.len() - 1
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high] = low;
        self.edge[low] |= self.edge[high];
    }

    fn inner(&self) -> Vec<[u32; 2]> {
        (0..self.parent.len()).filter(|&i| self.parent[i] == i && !self.edge[i]).map(|i| self.cell[i]).collect()
    }
}

impl Rays {
    /// The rays of those points that lie where `keep` says.
    pub fn new(points: &[Point], keep: impl Fn(Point) -> bool) -> Self {
        let mut points: Vec<Point> = points.iter().copied().filter(|p| keep(*p)).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        Self { points }
    }

    /// Adds the crossings of the way from `a` to `b` that has no more than one point above each `x`, its height given by `height`.
    fn along(&self, a: f64, b: f64, height: impl Fn(f64) -> f64, word: &mut Word) {
        let (low, high) = (a.min(b), a.max(b));
        let first = self.points.partition_point(|p| p[0] < low);
        let last = self.points.partition_point(|p| p[0] < high);
        let above = |i: &usize| height(self.points[*i][0]) > self.points[*i][1];
        let letter = |i: usize| i as i32 + 1;
        if a < b {
            word.extend((first..last).filter(above).map(letter));
        } else {
            word.extend((first..last).rev().filter(above).map(|i| -letter(i)));
        }
    }

    /// Adds the crossings of a straight line.
    pub fn line(&self, a: Point, b: Point, word: &mut Word) {
        self.along(a[0], b[0], |x| a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0])), word);
    }

    /// Adds the crossings of an arc from `ends[0]` to `ends[1]` around a centre: its first angle and signed turn, rad.
    pub fn arc(&self, (center, radius): (Point, f64), [from, turn]: [f64; 2], ends: [Point; 2], word: &mut Word) {
        if radius == 0.0 || turn == 0.0 {
            return;
        }
        // Pieces with one point above each x end at multiples of pi.
        let (low, high) = (from.min(from + turn), from.max(from + turn));
        let mut cuts: Vec<f64> = ((low / PI).floor() as i64 + 1..(high / PI).ceil() as i64).map(|k| k as f64).collect();
        if turn < 0.0 {
            cuts.reverse();
        }
        let side = |k: f64| center[0] + if k.rem_euclid(2.0) == 0.0 { radius } else { -radius };
        let stops: Vec<(f64, f64)> =
            std::iter::once((from, ends[0][0])).chain(cuts.iter().map(|k| (k * PI, side(*k)))).chain([(from + turn, ends[1][0])]).collect();
        for w in stops.windows(2) {
            let upper = f64::midpoint(w[0].0, w[1].0).sin();
            let height = |x: f64| center[1] + (radius * radius - (x - center[0]).powi(2)).max(0.0).sqrt().copysign(upper);
            self.along(w[0].1, w[1].1, height, word);
        }
    }

    /// The reduced word of a polyline.
    pub fn word(&self, points: &[Point]) -> Word {
        let mut all = Word::new();
        for w in points.windows(2) {
            self.line(w[0], w[1], &mut all);
        }
        let mut word = Word::new();
        append(&mut word, &all);
        word
    }
}

/// Appends crossings; each cancels the one before it if it leads straight back.
pub(in crate::plan) fn append(word: &mut Word, more: &[i32]) {
    for &letter in more {
        if word.last() == Some(&-letter) {
            word.pop();
        } else {
            word.push(letter);
        }
    }
}

/// Reduced words by number; number 0 is the empty one.
pub(in crate::plan) struct Words {
    all: Vec<Word>,
    numbers: HashMap<Word, u32>,
}

impl Words {
    pub fn new() -> Self {
        Self { all: vec![Word::new()], numbers: HashMap::from([(Word::new(), 0)]) }
    }

    /// The word of a number.
    pub fn word(&self, number: u32) -> &Word {
        &self.all[number as usize]
    }

    /// The number of a word with more crossings.
    pub fn then(&mut self, number: u32, more: &[i32]) -> u32 {
        if more.is_empty() {
            return number;
        }
        let mut word = self.word(number).clone();
        append(&mut word, more);
        if let Some(&known) = self.numbers.get(&word) {
            return known;
        }
        let next = self.all.len() as u32;
        self.all.push(word.clone());
        self.numbers.insert(word, next);
        next
    }
}
