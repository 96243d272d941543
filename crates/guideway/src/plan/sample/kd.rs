//! Nearest neighbours among points that arrive one by one.
//!
//! A k-d tree in the plane. It is built anew, balanced, each time the number of points has grown by a quarter, so that it is no list even where points
//! come in a row.

use crate::Point;

/// No child.
const NONE: u32 = u32::MAX;
/// Up to so many points the tree stays as it grew.
const SMALL: usize = 32;

/// The tree; points are known by the order in which they came.
#[derive(Debug, Default)]
pub(super) struct Kd {
    points: Vec<Point>,
    /// Left (smaller or equal along the axis) and right child.
    children: Vec<[u32; 2]>,
    root: usize,
    rebuild: usize,
}

impl Kd {
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    pub fn insert(&mut self, p: Point) {
        let new = self.points.len() as u32;
        self.points.push(p);
        self.children.push([NONE; 2]);
        if self.points.len() > self.rebuild.max(SMALL) {
            self.rebuild = self.points.len() * 5 / 4;
            let mut all: Vec<u32> = (0..=new).collect();
            self.root = self.balanced(&mut all, 0) as usize;
            return;
        }
        if new == 0 {
            return;
        }
        let (mut at, mut axis) = (self.root, 0);
        loop {
            let side = usize::from(p[axis] > self.points[at][axis]);
            let child = &mut self.children[at][side];
            if *child == NONE {
                *child = new;
                return;
            }
            (at, axis) = (*child as usize, 1 - axis);
        }
    }

    /// The root of a balanced tree of some points.
    fn balanced(&mut self, some: &mut [u32], axis: usize) -> u32 {
        if some.is_empty() {
            return NONE;
        }
        let middle = some.len() / 2;
        let key = |i: &u32| self.points[*i as usize][axis];
        some.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (left, rest) = some.split_at_mut(middle);
        let (root, right) = (rest[0], &mut rest[1..]);
        let children = [self.balanced(left, 1 - axis), self.balanced(right, 1 - axis)];
        self.children[root as usize] = children;
        root
    }

    /// The point nearest to `p`; 0 in an empty tree.
    pub fn nearest(&self, p: Point) -> usize {
        let (mut best, mut found) = (f64::INFINITY, 0);
        self.walk(p, |i, square| {
            if square < best || square == best && i < found {
                (best, found) = (square, i);
            }
            best
        });
        found
    }

    /// Leaves the points within `radius` of `p` in `out`.
    pub fn within(&self, p: Point, radius: f64, out: &mut Vec<usize>) {
        out.clear();
        self.walk(p, |i, square| {
            if square <= radius * radius {
                out.push(i);
            }
            radius * radius
        });
    }

    /// Visits points with the square of their distance; `visit` says up to which square more are wanted.
    fn walk(&self, p: Point, mut visit: impl FnMut(usize, f64) -> f64) {
        let (mut todo, mut reach) = (Vec::with_capacity(64), f64::INFINITY);
        if !self.points.is_empty() {
            todo.push((self.root as u32, 0, 0.0));
        }
        while let Some((at, axis, beyond)) = todo.pop() {
            if at == NONE || beyond > reach {
                continue;
            }
            let q = self.points[at as usize];
            let d = [p[0] - q[0], p[1] - q[1]];
            reach = visit(at as usize, d[0] * d[0] + d[1] * d[1]);
            let near = usize::from(d[axis] > 0.0);
            let children = self.children[at as usize];
            todo.push((children[1 - near], 1 - axis, d[axis] * d[axis]));
            todo.push((children[near], 1 - axis, 0.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    fn square(a: Point, b: Point) -> f64 {
        (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])
    }

    #[test]
    fn agrees_with_a_look_at_all_points() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for kind in 0..4 {
            let mut tree = Kd::default();
            for i in 0..700 {
                // Random, few values that repeat, in a row, all the same.
                let p = match kind {
                    0 => [rng.random_range(0.0..1.0), rng.random_range(0.0..1.0)],
                    1 => [f64::from(rng.random_range(0..5)), f64::from(rng.random_range(0..5))],
                    2 => [f64::from(i), f64::from(i)],
                    _ => [1.0, 2.0],
                };
                tree.insert(p);
                let q = [rng.random_range(-1.0..6.0), rng.random_range(-1.0..6.0)];
                let best = (0..=i as usize).min_by(|&a, &b| square(tree.points[a], q).total_cmp(&square(tree.points[b], q))).unwrap();
                assert_eq!(tree.nearest(q), best);
                let (mut found, radius) = (Vec::new(), rng.random_range(0.0..2.0));
                tree.within(q, radius, &mut found);
                found.sort_unstable();
                let wanted: Vec<usize> = (0..=i as usize).filter(|&k| square(tree.points[k], q) <= radius * radius).collect();
                assert_eq!(found, wanted);
            }
        }
    }

    #[test]
    fn many_points_in_a_row() {
        let mut tree = Kd::default();
        for i in 0..10_000 {
            tree.insert([f64::from(i), 0.0]);
        }
        assert_eq!(tree.nearest([12.4, 3.0]), 12);
    }
}
