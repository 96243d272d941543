//! Where how fast may be driven: a map of speed limits.

use super::bits::Bits;
use super::grid::Grid;
use crate::Point;
use crate::error::PlanError;

/// Largest speed per cell of a map of its own. The place of the robot's reference point counts.
#[derive(Debug, Clone)]
pub struct SpeedMap {
    frame: Grid,
    /// m/s, row after row from the bottom; infinite without a limit.
    limits: Vec<f32>,
    /// The same, the least of the cell and those around it.
    around: Vec<f32>,
}

impl SpeedMap {
    /// From limits (m/s, row after row from the bottom, infinite without one) on `size` columns and rows of side `resolution` (m) with their lower-left corner at `origin`
    /// (x, y in m, yaw in rad).
    /// # Errors
    /// [`PlanError::BadParameter`] for limits that are not positive, a size that does not fit, or a frame that makes no sense.
    pub fn new(limits: &[f64], size: [u32; 2], resolution: f64, origin: [f64; 3]) -> Result<Self, PlanError> {
        let [w, h] = size.map(|n| n as usize);
        if w.checked_mul(h) != Some(limits.len()) {
            return Err(PlanError::bad("speed map", format!("{} limits for {w} x {h} cells", limits.len()), "one for each cell"));
        }
        let frame = Grid::new(Bits::new(size[0], size[1]), None, resolution, origin)?;
        if let Some(bad) = limits.iter().find(|v| v.is_nan() || **v < 1e-3) {
            return Err(PlanError::bad(
                "speed map",
                format!("{bad} m/s"),
                "at least 0.001 m/s, or infinite; forbidden areas belong in a keep-out mask",
            ));
        }
        // Rounded towards zero, so that what keeps the rounded limit keeps the limit.
        let limits: Vec<f32> = limits.iter().map(|v| if f64::from(*v as f32) > *v { (*v as f32).next_down() } else { *v as f32 }).collect();
        let around = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| {
            let rows = y.saturating_sub(1)..=(y + 1).min(h - 1);
            let least = |y: usize| limits[y * w + x.saturating_sub(1)..=y * w + (x + 1).min(w - 1)].iter().copied().fold(f32::INFINITY, f32::min);
            rows.map(least).fold(f32::INFINITY, f32::min)
        });
        Ok(Self { around: around.collect(), limits, frame })
    }

    fn index(&self, p: Point) -> Option<usize> {
        self.frame.cell_at(p).map(|[x, y]| y as usize * self.frame.width() as usize + x as usize)
    }

    /// Largest speed at `p` (m), m/s; infinite without a limit and outside the map.
    pub fn at(&self, p: Point) -> f64 {
        self.index(p).map_or(f64::INFINITY, |i| f64::from(self.limits[i]))
    }

    /// The least of the cell at `p` (m) and those around it, m/s: holds for all places nearer than the side of a cell.
    pub fn around(&self, p: Point) -> f64 {
        if let Some(i) = self.index(p) {
            return f64::from(self.around[i]);
        }
        // Outside, but perhaps nearer than a cell's side to its border.
        let [x, y] = self.frame.to_cells(p);
        let inside = |v: f64, n: u32| (v > -1.0 && v < f64::from(n) + 1.0).then(|| (v.max(0.0) as u32).min(n - 1));
        match (inside(x, self.frame.width()), inside(y, self.frame.height())) {
            (Some(x), Some(y)) => f64::from(self.around[y as usize * self.frame.width() as usize + x as usize]),
            _ => f64::INFINITY,
        }
    }

    /// Side of a cell, m.
    pub fn resolution(&self) -> f64 {
        self.frame.resolution()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_cell_and_around() {
        let mut limits = vec![f64::INFINITY; 12];
        limits[5] = 0.3; // column 1, row 1
        let map = SpeedMap::new(&limits, [4, 3], 0.5, [1.0, 2.0, 0.0]).unwrap();
        assert!(map.at([1.7, 2.7]) <= 0.3 && map.at([1.7, 2.7]) > 0.2999);
        assert!(map.at([1.2, 2.7]).is_infinite() && map.at([-9.0, 0.0]).is_infinite());
        assert!(map.around([1.2, 2.2]) <= 0.3 && map.around([2.9, 2.2]).is_infinite() && map.around([0.9, 2.7]) <= 0.3);
        assert!(map.around([0.4, 2.7]).is_infinite());
        let bad = |limits: &[f64], size| SpeedMap::new(limits, size, 0.5, [0.0; 3]).is_err();
        assert!(bad(&[0.0], [1, 1]) && bad(&[f64::NAN], [1, 1]) && bad(&[1.0], [2, 1]) && bad(&[], [0, 0]));
    }
}
