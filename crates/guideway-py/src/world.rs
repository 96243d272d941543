//! `World` and the distance transform.

use crate::convert::{from_python, points, rows, to_python};
use crate::errors::{OrPy, to_py};
use guideway::error::PlanError;
use guideway::plan::search;
use guideway::world::{self, Bits, Grid, Mover, Shape};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is blocked, where the robot may be, and how far away everything is. Immutable.
#[pyclass(frozen, module = "guideway")]
pub struct World {
    pub inner: Arc<world::World>,
    #[pyo3(get)]
    source: Option<String>,
    #[pyo3(get)]
    sha256: Option<String>,
    /// sha256 of every file that was read, by name.
    #[pyo3(get)]
    files: BTreeMap<String, String>,
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (blocked=None, resolution=1.0, origin=[0.0, 0.0, 0.0], *, unknown=None, bounds=None, shapes=None, movers=None, source=None, sha256=None, files=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python constructor")]
    fn new(
        py: Python<'_>,
        blocked: Option<&Bound<'_, PyAny>>,
        resolution: f64,
        origin: [f64; 3],
        unknown: Option<&Bound<'_, PyAny>>,
        bounds: Option<[f64; 4]>,
        shapes: Option<&Bound<'_, PyAny>>,
        movers: Option<&Bound<'_, PyAny>>,
        source: Option<String>,
        sha256: Option<String>,
        files: Option<BTreeMap<String, String>>,
    ) -> PyResult<Self> {
        let shapes: Vec<Shape> = shapes.map_or(Ok(Vec::new()), |s| from_python("shapes", s))?;
        let shapes = shapes.into_iter().map(Shape::validated).collect::<Result<Vec<_>, _>>().or_py(py)?;
        let movers = movers.map_or(Ok(Vec::new()), self::movers)?;
        let inner = if let Some(blocked) = blocked {
            let bits = bits(blocked, Rows::TopFirst)?;
            let unknown = unknown.map(|u| self::bits(u, Rows::TopFirst)).transpose()?;
            if unknown.as_ref().is_some_and(|u| u.width() != bits.width() || u.height() != bits.height()) {
                return Err(to_py(py, &PlanError::bad("unknown", "its shape", "the shape of blocked")));
            }
            let grid = Grid::new(bits, unknown, resolution, origin).or_py(py)?;
            world::World::from_grid(grid).with_shapes(shapes)
        } else {
            let bounds = bounds.ok_or_else(|| to_py(py, &PlanError::bad("World", "neither blocked nor bounds", "an occupancy array, or bounds")))?;
            world::World::from_shapes(bounds, shapes, resolution).or_py(py)?
        };
        Ok(Self { inner: Arc::new(inner.with_movers(movers)), source, sha256, files: files.unwrap_or_default() })
    }

    /// Reads a map (`map_server` YAML, Moving AI, text) or the world of a scene TOML.
    #[staticmethod]
    #[pyo3(signature = (path, **options))]
    fn load<'py>(py: Python<'py>, path: &Bound<'py, PyAny>, options: Option<&Bound<'py, pyo3::types::PyDict>>) -> PyResult<Bound<'py, PyAny>> {
        py.import("guideway.worlds")?.getattr("load")?.call((path,), options)
    }

    /// The same static world under other moving obstacles (dictionaries as in `movers`).
    fn with_movers(&self, movers: &Bound<'_, PyAny>) -> PyResult<Self> {
        let movers = self::movers(movers)?;
        Ok(self.like(self.inner.overlaid(movers)))
    }

    /// The same world with a part of its map changed: `blocked` (height, width), row 0 on top, replaces the cells from `row`, `column` of the image on. Distances that
    /// were computed are brought up to date where they can have changed.
    #[pyo3(signature = (blocked, row=0, column=0))]
    fn updated(&self, py: Python<'_>, blocked: &Bound<'_, PyAny>, row: u32, column: u32) -> PyResult<Self> {
        let part = bits(blocked, Rows::TopFirst)?;
        let [_, height] = self.inner.cells();
        // The part's row 0 is its lowest; on the map that is `bottom`.
        let bottom = i64::from(height) - i64::from(row) - i64::from(part.height());
        let Ok(bottom) = u32::try_from(bottom) else {
            let shown = format!("{} rows from row {row} on", part.height());
            return Err(to_py(py, &PlanError::bad("blocked", shown, format!("a part of the map of {height} rows"))));
        };
        let mut changes = Vec::new();
        for y in 0..part.height() {
            changes.extend((0..part.width()).map(|x| ([column.saturating_add(x), bottom + y], part.at(x, y))));
        }
        let inner = py.detach(|| self.inner.updated(&changes)).or_py(py)?;
        Ok(Self { inner: Arc::new(inner), source: None, sha256: None, files: BTreeMap::new() })
    }

    /// The same world with the areas that a keep-out mask forbids: a `map_server` file, or a bool array of shape (height, width), row 0 on top, that lies like the
    /// world's own map. A cell that a forbidden one touches is forbidden; cells that the mask does not know are not. Planners and controllers keep off them as off
    /// obstacles; lidars, simulators and the judge of collisions see `solid`.
    fn with_keep_out<'py>(slf: &Bound<'py, Self>, mask: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("guideway.site_rules")?.getattr("with_keep_out")?.call1((slf, mask))
    }

    /// The same world in which these places are forbidden as well, though nothing stands there: cells, a bool array of shape (height, width), row 0 on top, for worlds
    /// with a map; shapes, dictionaries as in `shapes`, for any.
    #[pyo3(signature = (cells=None, shapes=None))]
    fn forbidding(&self, py: Python<'_>, cells: Option<&Bound<'_, PyAny>>, shapes: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let cells = cells.map(|c| bits(c, Rows::TopFirst)).transpose()?;
        let shapes: Vec<Shape> = shapes.map_or(Ok(Vec::new()), |s| from_python("shapes", s))?;
        let shapes = shapes.into_iter().map(Shape::validated).collect::<Result<Vec<_>, _>>().or_py(py)?;
        Ok(self.like(self.inner.forbidding(cells.as_ref(), shapes).or_py(py)?))
    }

    /// What a robot without a map knows of this world before it has seen anything: its bounds, and what is forbidden.
    fn emptied(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self { inner: Arc::new(self.inner.emptied().or_py(py)?), source: None, sha256: None, files: BTreeMap::new() })
    }

    /// The world as it is, with its movers: without what is only forbidden.
    #[getter]
    fn solid(&self) -> Self {
        self.like(self.inner.solid().overlaid(self.inner.movers().to_vec()))
    }

    /// Exact distance from every cell's centre to the nearest static obstacle, m, shape (height, width), row 0 on top; infinite without obstacles.
    fn clearance_field<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let inner = &self.inner;
        let field = py.detach(|| inner.clearance_field());
        let (w, h) = (field.width() as usize, field.height() as usize);
        let values = field.values();
        let flipped: Vec<f64> = values.chunks_exact(w).rev().flatten().copied().collect();
        PyArray1::from_vec(py, flipped).reshape([h, w])
    }

    /// Cells across (of the map, or of the lattice that grid planners see).
    #[getter]
    fn width(&self) -> u32 {
        self.inner.cells()[0]
    }
    /// Cells up.
    #[getter]
    fn height(&self) -> u32 {
        self.inner.cells()[1]
    }
    /// Side of a cell, m.
    #[getter]
    fn resolution(&self) -> f64 {
        self.inner.resolution()
    }
    /// (x, y, yaw) of the lower-left corner, m, m, rad.
    #[getter]
    fn origin(&self) -> [f64; 3] {
        self.inner.grid().map_or([self.inner.bounds()[0], self.inner.bounds()[1], 0.0], Grid::origin)
    }
    /// (x0, y0, x1, y1), m.
    #[getter]
    fn bounds(&self) -> [f64; 4] {
        self.inner.bounds()
    }
    /// Analytic obstacles as dictionaries.
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.shapes())
    }
    /// Moving obstacles as dictionaries.
    #[getter]
    fn movers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.movers())
    }

    /// Cells as uint8 of shape (height, width), row 0 on top: 0 free, 1 blocked, 2 unknown and blocked. None without a map.
    fn occupancy<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<u8>>>> {
        let Some(grid) = self.inner.grid() else { return Ok(None) };
        let (w, h) = (grid.width(), grid.height());
        let mut cells = Vec::with_capacity(w as usize * h as usize);
        for y in (0..h).rev() {
            cells.extend((0..w).map(|x| match (grid.blocked().at(x, y), grid.unknown().is_some_and(|u| u.at(x, y))) {
                (false, _) => 0,
                (true, false) => 1u8,
                (true, true) => 2,
            }));
        }
        Ok(Some(PyArray1::from_vec(py, cells).reshape([h as usize, w as usize])?))
    }

    /// Exact distance to the nearest static obstacle at points of shape (n, 2), m; negative inside one.
    fn clearance<'py>(&self, py: Python<'py>, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let rows = rows("points", points)?;
        let inner = &self.inner;
        let values: Vec<f64> = py.detach(|| rows.iter().map(|&p| inner.clearance(p)).collect());
        Ok(PyArray1::from_vec(py, values))
    }

    /// Does a disc of this radius (m), swept along the segment from a to b (m), stay out of every static obstacle?
    fn segment_free(&self, py: Python<'_>, a: [f64; 2], b: [f64; 2], radius: f64) -> PyResult<bool> {
        if !(0.0..=1e6).contains(&radius) {
            return Err(to_py(py, &PlanError::bad("radius", radius, "0 to 1e6 m")));
        }
        Ok(self.inner.segment_free(a, b, radius))
    }

    /// Exact shortest lattice path of a point robot between two cells (column, row), row 0 on top, by jump point search \[harabor2011\], \[harabor2014\].
    ///
    /// Returns (length in cells, turning points as (column, row) from start to goal), or None if a cell is blocked or outside or there is no path. The lean
    /// call for many queries: no certificate, no record. `corners` as in `Query`.
    #[pyo3(signature = (start, goal, corners="clear"))]
    fn shortest(&self, py: Python<'_>, start: (u32, u32), goal: (u32, u32), corners: &str) -> PyResult<Option<(f64, Turns)>> {
        let corners = crate::query::corner_rule(py, corners)?;
        let lattice = self.inner.lattice(0.0);
        let Some(top) = lattice.height().checked_sub(1).filter(|top| start.1 <= *top && goal.1 <= *top) else { return Ok(None) };
        let mut turns = Vec::new();
        let flip = |c: (u32, u32)| [c.0, top - c.1];
        let steps = search::shortest_cells(&lattice, flip(start), flip(goal), corners, &mut turns);
        Ok(steps.map(|steps| (steps.length(), turns.iter().map(|c| (c[0], top - c[1])).collect())))
    }

    /// Centre (m) of cells given as (column, row), row 0 on top, shape (n, 2).
    fn cell_centers<'py>(&self, py: Python<'py>, cells: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let [_, h] = self.inner.cells();
        let rows = rows("cells", cells)?;
        let centers: Vec<_> = rows.iter().map(|c| self.inner.cell_to_map([c[0] + 0.5, f64::from(h) - c[1] - 0.5])).collect();
        self::points(py, &centers)
    }

    fn __repr__(&self) -> String {
        let [w, h] = self.inner.cells();
        let source = self.source.as_deref().unwrap_or("from memory");
        format!(
            "World({source}: {w} x {h} cells of {} m, {} shapes, {} movers)",
            self.inner.resolution(),
            self.inner.shapes().len(),
            self.inner.movers().len()
        )
    }
}

impl World {
    /// Another content from the same source.
    fn like(&self, inner: world::World) -> Self {
        Self { inner: Arc::new(inner), source: self.source.clone(), sha256: self.sha256.clone(), files: self.files.clone() }
    }
}

/// Turning points of a lattice path as (column, row), row 0 on top.
type Turns = Vec<(u32, u32)>;

fn movers(objects: &Bound<'_, PyAny>) -> PyResult<Vec<Mover>> {
    let movers: Vec<Mover> = from_python("movers", objects)?;
    movers.into_iter().map(Mover::validated).collect::<Result<_, _>>().or_py(objects.py())
}

/// Distance from each cell's centre to the centre of the nearest blocked cell, in cells; infinite if none is blocked.
///
/// `blocked` has shape (height, width); the result is float64 of the same shape. Exact \[felzenszwalb2012\].
#[pyfunction]
pub fn distance_transform<'py>(py: Python<'py>, blocked: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let bits = bits(blocked, Rows::AsGiven)?;
    let (w, h) = (bits.width() as usize, bits.height() as usize);
    let values = py.detach(|| world::distances(&bits)).or_py(py)?;
    PyArray1::from_vec(py, values).reshape([h, w])
}

/// Where row 0 of an array goes.
#[derive(Clone, Copy, PartialEq)]
enum Rows {
    /// To row 0.
    AsGiven,
    /// To the top row: bits count from the bottom.
    TopFirst,
}

/// Packs a (height, width) array into bits.
fn bits(object: &Bound<'_, PyAny>, rows: Rows) -> PyResult<Bits> {
    let py = object.py();
    if let Ok(array) = object.extract::<PyReadonlyArray2<'_, bool>>() {
        return pack(py, &array, rows);
    }
    let bad = |_| to_py(py, &PlanError::bad("blocked", "the value given", "a boolean array of shape (height, width), true where blocked"));
    let array = py.import("numpy")?.call_method1("asarray", (object, "bool")).map_err(bad)?;
    pack(py, &array.extract::<PyReadonlyArray2<'_, bool>>().map_err(bad)?, rows)
}

/// Up to eight cells as the bits of a byte: one multiplication moves bit 0 of byte `i` to bit `56 + i`.
#[inline]
fn eight(cells: &[bool]) -> u64 {
    let mut bytes = [0; 8];
    bytes.iter_mut().zip(cells).for_each(|(byte, &b)| *byte = u8::from(b));
    u64::from_le_bytes(bytes).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

fn pack(py: Python<'_>, array: &PyReadonlyArray2<'_, bool>, rows: Rows) -> PyResult<Bits> {
    let (h, w) = (array.shape()[0], array.shape()[1]);
    if w == 0 || h == 0 || (w as u64).saturating_mul(h as u64) > world::MAX_CELLS {
        return Err(to_py(py, &PlanError::bad("blocked", format!("shape ({h}, {w})"), format!("1 to {} cells", world::MAX_CELLS))));
    }
    let mut bits = Bits::new(w as u32, h as u32);
    let view = array.as_array();
    for (i, row) in view.rows().into_iter().enumerate() {
        let y = if rows == Rows::TopFirst { h - 1 - i } else { i };
        let words = bits.row_mut(y as u32);
        if let Some(cells) = row.as_slice() {
            for (word, chunk) in words.iter_mut().zip(cells.chunks(64)) {
                *word = chunk.chunks(8).rev().fold(0, |acc, cells| acc << 8 | eight(cells));
            }
        } else {
            for (x, &b) in row.iter().enumerate() {
                words[x / 64] |= u64::from(b) << (x % 64);
            }
        }
    }
    Ok(bits)
}
