//! Brute force over all cells, shared by the tests of the world and of the checker. Grid frame, cells.

use guideway::Point;
use guideway::world::{Bits, Grid, World, shape};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn below(&mut self, n: u32) -> u32 {
        (self.unit() * f64::from(n)) as u32
    }
    pub fn bits(&mut self, w: u32, h: u32, share: f64) -> Bits {
        let mut bits = Bits::new(w, h);
        for y in 0..h {
            for x in 0..w {
                let on = self.unit() < share;
                bits.set(x, y, on);
            }
        }
        bits
    }
}

/// Resolutions and origins: plain, shifted, turned.
pub const PLACES: [(f64, [f64; 3]); 3] = [(1.0, [0.0; 3]), (0.05, [-3.0, 7.5, 0.0]), (0.3, [100.0, -20.0, 0.7])];

pub fn world(bits: &Bits, resolution: f64, origin: [f64; 3]) -> World {
    World::from_grid(Grid::new(bits.clone(), None, resolution, origin).expect("a valid grid"))
}

pub fn squares(bits: &Bits, on: bool) -> Vec<Point> {
    let cells = (0..bits.height()).flat_map(|y| (0..bits.width()).map(move |x| (x, y)));
    cells.filter(|&(x, y)| bits.at(x, y) == on).map(|(x, y)| [f64::from(x), f64::from(y)]).collect()
}

pub fn to_square(q: Point, s: Point) -> f64 {
    let gap = |q: f64, s: f64| (s - q).max(q - s - 1.0).max(0.0);
    gap(q[0], s[0]).hypot(gap(q[1], s[1]))
}

/// Signed distance to the union of the set squares, by looking at every cell.
pub fn signed(bits: &Bits, q: Point) -> f64 {
    let nearest = |on| squares(bits, on).into_iter().map(|s| to_square(q, s)).fold(f64::INFINITY, f64::min);
    let outside = nearest(true);
    let (w, h) = (f64::from(bits.width()), f64::from(bits.height()));
    if outside > 0.0 { outside } else { -nearest(false).min(q[0]).min(q[1]).min(w - q[0]).min(h - q[1]).max(0.0) }
}

pub fn segment_to_square(a: Point, b: Point, s: Point) -> f64 {
    let c = [s, [s[0] + 1.0, s[1]], [s[0] + 1.0, s[1] + 1.0], [s[0], s[1] + 1.0]];
    if to_square(a, s) == 0.0 || to_square(b, s) == 0.0 {
        return 0.0;
    }
    (0..4).map(|i| shape::segment_segment(a, b, c[i], c[(i + 1) % 4])).fold(f64::INFINITY, f64::min)
}

/// Exact for a point robot: between two crossings of grid lines a segment stays in one cell or on one line, so its middle tells whether it keeps to a
/// free cell (closed).
pub fn point_free(bits: &Bits, a: Point, b: Point) -> bool {
    let at = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    let mut cuts = vec![0.0, 1.0];
    for k in 0..2 {
        for line in 0..=bits.width().max(bits.height()) {
            let t = (f64::from(line) - a[k]) / (b[k] - a[k]);
            if t > 0.0 && t < 1.0 {
                cuts.push(t);
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    let through = |t: f64| {
        let p = at(t);
        let (x, y) = (p[0].round(), p[1].round());
        (p[0] - x).abs().max((p[1] - y).abs()) < 1e-7 && pinched(bits, x, y)
    };
    let cells = squares(bits, false);
    let open = |p: Point| cells.iter().any(|&s| to_square(p, s) < 1e-6);
    let middles = cuts.windows(2).all(|w| open(at(f64::midpoint(w[0], w[1]))));
    middles && open(a) && open(b) && !cuts.iter().any(|&t| t > 1e-9 && t < 1.0 - 1e-9 && through(t))
}

/// Do two set squares meet at this corner diagonally?
pub fn pinched(bits: &Bits, x: f64, y: f64) -> bool {
    let set = |x: f64, y: f64| x >= 0.0 && y >= 0.0 && x < f64::from(bits.width()) && y < f64::from(bits.height()) && bits.at(x as u32, y as u32);
    let [sw, se, nw, ne] = [set(x - 1.0, y - 1.0), set(x, y - 1.0), set(x - 1.0, y), set(x, y)];
    sw == ne && se == nw && sw != se
}
