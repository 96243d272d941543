//! Worlds that differ a little from one that is known: what was computed from that one is kept where it still holds.

use super::distance::SquareField;
use super::rules::Rules;
use super::{Bits, Cell, Grid, Shape, World};
use crate::error::PlanError;
use std::sync::{Arc, OnceLock};

impl World {
    /// The same world with these cells of its map blocked (true) or free, the last change of a cell counting; what is forbidden stays so. Distances that were computed are brought up to date, and
    /// computed anew only for rows that a change can matter to; the result is the same as that of a new world. Lattices are built when they are asked for.
    /// # Errors
    /// [`PlanError::BadParameter`] for a world without a map or a cell outside it.
    pub fn updated(&self, changes: &[(Cell, bool)]) -> Result<Self, PlanError> {
        let Some(grid) = self.grid() else {
            return Err(PlanError::bad("world", "a world of shapes alone", "a world with a map, whose cells can change"));
        };
        if let Some(([x, y], _)) = changes.iter().find(|([x, y], _)| *x >= grid.width() || *y >= grid.height()) {
            let allowed = format!("cells of the map: columns below {}, rows below {}", grid.width(), grid.height());
            return Err(PlanError::bad("changes", format!("cell ({x}, {y})"), allowed));
        }
        let rules = self.rules.as_ref().map(|r| Ok(Rules { solid: Arc::new(r.solid.updated(changes)?), ..r.clone() })).transpose()?;
        let kept = |[x, y]: Cell| self.forbidden().and_then(Self::grid).is_some_and(|g| g.blocked().at(x, y));
        let obeyed: Vec<(Cell, bool)> = changes.iter().map(|&(cell, on)| (cell, on || kept(cell))).collect();
        let new = grid.with(&obeyed);
        let differs = |&&([x, y], _): &&(Cell, bool)| grid.blocked().at(x, y) != new.blocked().at(x, y);
        let changed: Vec<Cell> = changes.iter().filter(differs).map(|c| c.0).collect();
        let squares = OnceLock::new();
        if let Some(before) = self.squares.get() {
            let kept = || Arc::clone(before);
            let made = || Arc::new(SquareField::updated(before, grid.blocked(), new.blocked(), &changed));
            squares.get_or_init(if changed.is_empty() { &kept as &dyn Fn() -> _ } else { &made });
        }
        Ok(Self { squares, movers: self.movers.clone(), rules, ..self.changed(Some(new), self.shapes.clone()) })
    }

    /// The static world with more shapes, without movers. Distances to blocked cells that were computed are kept.
    #[must_use]
    pub fn extended(&self, shapes: impl IntoIterator<Item = Shape>) -> Self {
        let more: Vec<Shape> = shapes.into_iter().collect();
        let rules = self.rules.as_ref().map(|r| Rules { solid: Arc::new(r.solid.extended(more.iter().cloned())), ..r.clone() });
        let all = self.shapes.iter().cloned().chain(more).collect();
        Self { squares: self.squares.clone(), rules, ..self.changed(self.grid.clone(), all) }
    }

    /// The frame of this world with nothing in it but what is forbidden.
    /// # Errors
    /// None for worlds that were made.
    pub fn emptied(&self) -> Result<Self, PlanError> {
        let empty = |g: &Grid| Grid::new(Bits::new(g.width(), g.height()), None, g.resolution(), g.origin());
        let empty = self.changed(self.grid.as_ref().map(empty).transpose()?, Vec::new());
        Ok(empty.ruled_as(self))
    }

    /// This world's frame with another content of which nothing is computed.
    pub(super) fn changed(&self, grid: Option<Grid>, shapes: Vec<Shape>) -> Self {
        Self::bare(grid, shapes, self.bounds, self.resolution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    fn world(blocked: &Bits) -> World {
        World::from_grid(Grid::new(blocked.clone(), None, 0.1, [1.0, -2.0, 0.3]).unwrap())
    }

    proptest! {
        #[test]
        fn a_changed_world_is_the_same_as_a_new_one(
            [w, h] in [1_u32..150, 1_u32..90], share in 0..40_u32, changes in 0..60_usize, spread in 1_u32..90, seed in 0..u64::MAX, shapes in proptest::bool::ANY
        ) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut blocked = Bits::new(w, h);
            for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
                blocked.set(x, y, rng.random_range(0..400) < share);
            }
            let more = |world: World| if shapes { world.with_shapes(vec![Shape::disc([3.0, 0.0], 0.4).unwrap()]) } else { world };
            let mut changed = more(world(&blocked));
            changed.clearance_field();
            for _ in 0..3 {
                let (x0, y0) = (rng.random_range(0..w), rng.random_range(0..h));
                let list: Vec<(Cell, bool)> = (0..changes)
                    .map(|_| ([(x0 + rng.random_range(0..spread)).min(w - 1), (y0 + rng.random_range(0..spread)).min(h - 1)], rng.random_bool(0.5)))
                    .collect();
                for ([x, y], on) in &list {
                    blocked.set(*x, *y, *on);
                }
                changed = changed.updated(&list).unwrap();
                let new = more(world(&blocked));
                prop_assert_eq!(changed.grid().unwrap().blocked(), &blocked);
                prop_assert_eq!(changed.clearance_field().values(), new.clearance_field().values());
                let (a, b) = (changed.lattice(0.17), new.lattice(0.17));
                prop_assert_eq!(a.free(), b.free());
            }
        }
    }

    #[test]
    fn shapes_are_added_and_movers_left_out() {
        let mut blocked = Bits::new(40, 30);
        blocked.set(20, 10, true);
        let before = world(&blocked);
        before.clearance_field();
        let disc = Shape::disc(before.cell_center([5, 5]), 0.2).unwrap();
        let (more, new) = (before.extended([disc.clone()]), world(&blocked).with_shapes(vec![disc]));
        assert_eq!(more.clearance_field().values(), new.clearance_field().values());
        assert!(more.squares.get().is_some_and(|kept| Arc::ptr_eq(kept, before.squares.get().unwrap())));
    }

    #[test]
    fn cells_outside_and_worlds_without_a_map_are_refused() {
        let map = world(&Bits::new(4, 3));
        assert!(map.updated(&[([4, 0], true)]).is_err() && map.updated(&[([0, 3], true)]).is_err() && map.updated(&[([3, 2], true)]).is_ok());
        assert!(World::from_shapes([0.0, 0.0, 1.0, 1.0], Vec::new(), 0.1).unwrap().updated(&[]).is_err());
    }
}
