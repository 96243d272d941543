//! Site rules: places that are forbidden, though nothing stands there.
//!
//! A world with rules is the world to plan and to steer in: forbidden places stop the robot like obstacles. It keeps the world as it is beside that, for
//! whatever follows the laws of nature and not of the site: sensors, physics, and the judge of collisions.

use super::{Bits, Grid, Shape, World};
use crate::error::PlanError;
use std::sync::Arc;

/// What is there, and what is forbidden, each in the frame of the whole.
#[derive(Debug, Clone)]
pub(super) struct Rules {
    pub solid: Arc<World>,
    pub forbidden: Arc<World>,
}

impl World {
    /// The same world, its movers too, in which these cells of its map and these shapes are forbidden as well.
    /// # Errors
    /// [`PlanError::BadParameter`] for cells in a world without a map, or of another size.
    pub fn forbidding(&self, cells: Option<&Bits>, shapes: Vec<Shape>) -> Result<Self, PlanError> {
        let size = self.grid().map(|g| (g.width(), g.height()));
        if let Some(cells) = cells.filter(|c| size != Some((c.width(), c.height()))) {
            let shown = format!("{} x {} cells", cells.width(), cells.height());
            return Err(PlanError::bad("forbidden cells", shown, "the size of the world's map"));
        }
        let before = self.rules.as_ref().map(|rules| &rules.forbidden);
        let all = before.map_or(&[][..], |f| f.shapes()).iter().cloned().chain(shapes).collect();
        let frame = self.emptied()?.grid.map(|grid| cells.map_or(grid.clone(), |more| grid.and(more)));
        let forbidden = Arc::new(self.changed(frame, all));
        let solid = self.rules.as_ref().map_or_else(|| Arc::new(self.overlaid(Vec::new())), |rules| Arc::clone(&rules.solid));
        Ok(Self::ruled(&solid, forbidden).with_movers(self.movers.clone()))
    }

    /// What is there under what is forbidden.
    pub(super) fn ruled(solid: &Arc<Self>, forbidden: Arc<Self>) -> Self {
        let grid = solid.grid().map(|grid| forbidden.grid().map_or(grid.clone(), |more| grid.and(more.blocked())));
        let shapes = solid.shapes.iter().chain(&forbidden.shapes).cloned().collect();
        Self { rules: Some(Rules { solid: Arc::clone(solid), forbidden }), ..solid.changed(grid, shapes) }
    }

    /// This world, of which nothing is forbidden yet, under the rules of another one: of the same frame, or of shapes alone.
    #[must_use]
    pub(crate) fn ruled_as(self, other: &Self) -> Self {
        match &other.rules {
            Some(rules) => Self::ruled(&Arc::new(self), Arc::clone(&rules.forbidden)),
            None => self,
        }
    }

    /// The world as it is: without what is only forbidden, and then without movers.
    pub fn solid(&self) -> &Self {
        self.rules.as_ref().map_or(self, |rules| &rules.solid)
    }

    /// What is forbidden as a world of its own, if anything is.
    pub fn forbidden(&self) -> Option<&Self> {
        self.rules.as_ref().map(|rules| &*rules.forbidden)
    }
}

impl Grid {
    /// The same grid with more cells blocked: a grid of the same size.
    fn and(&self, more: &Bits) -> Self {
        let mut grid = self.clone();
        grid.block(more);
        grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world() -> World {
        let mut blocked = Bits::new(40, 30);
        blocked.set(20, 10, true);
        World::from_grid(Grid::new(blocked, None, 0.1, [1.0, -2.0, 0.3]).unwrap())
    }

    fn cells(of: [u32; 2]) -> Bits {
        let mut cells = Bits::new(40, 30);
        cells.set(of[0], of[1], true);
        cells
    }

    #[test]
    fn what_is_forbidden_blocks_plans_and_is_not_there() {
        let before = world();
        let at = |cell| before.cell_center(cell);
        let disc = Shape::disc(at([30, 20]), 0.2).unwrap();
        let ruled = before.forbidding(Some(&cells([5, 5])), vec![disc]).unwrap().forbidding(Some(&cells([8, 5])), Vec::new()).unwrap();
        for cell in [[5, 5], [8, 5], [30, 20]] {
            assert!(ruled.clearance(at(cell)) < 0.0 && ruled.solid().clearance(at(cell)) > 0.0, "{cell:?}");
            assert!(ruled.forbidden().unwrap().clearance(at(cell)) < 0.0 && ruled.emptied().unwrap().clearance(at(cell)) < 0.0, "{cell:?}");
        }
        assert!(ruled.solid().clearance(at([20, 10])) < 0.0 && ruled.clearance(at([20, 10])) < 0.0);
        assert!(ruled.emptied().unwrap().clearance(at([20, 10])) > 0.0, "nothing seen yet");
        assert!(before.forbidden().is_none() && std::ptr::eq(before.solid(), &raw const before));
    }

    #[test]
    fn changes_of_the_map_do_not_lift_what_is_forbidden() {
        let ruled = world().forbidding(Some(&cells([5, 5])), Vec::new()).unwrap();
        let p = ruled.cell_center([5, 5]);
        let freed = ruled.updated(&[([5, 5], false), ([20, 10], false), ([7, 7], true)]).unwrap();
        assert!(freed.clearance(p) < 0.0 && freed.solid().clearance(p) > 0.0);
        assert!(freed.clearance(freed.cell_center([20, 10])) > 0.0 && freed.solid().clearance(freed.cell_center([7, 7])) < 0.0);
        let more = freed.extended([Shape::disc([3.0, 0.0], 0.3).unwrap()]);
        assert!(more.clearance(p) < 0.0 && more.solid().clearance([3.0, 0.0]) < 0.0 && more.solid().clearance(p) > 0.0);
        let shaped = freed.with_shapes(vec![Shape::disc([3.0, 0.0], 0.3).unwrap()]);
        assert!(shaped.clearance(p) < 0.0 && shaped.solid().clearance([3.0, 0.0]) < 0.0);
        assert!(shaped.overlaid(Vec::new()).solid().clearance(p) > 0.0);
    }

    #[test]
    fn forbidden_cells_need_a_map_of_their_size() {
        let open = World::from_shapes([0.0, 0.0, 1.0, 1.0], Vec::new(), 0.1).unwrap();
        assert!(open.forbidding(Some(&cells([5, 5])), Vec::new()).is_err() && world().forbidding(Some(&Bits::new(40, 29)), Vec::new()).is_err());
        assert!(open.forbidding(None, vec![Shape::disc([0.5, 0.5], 0.1).unwrap()]).unwrap().clearance([0.5, 0.5]) < 0.0);
    }
}
