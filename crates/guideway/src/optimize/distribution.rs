//! The normal distribution of the covariance matrix adaptation, and how it learns. Source: \[hansen2016\]; equations are numbered as there.

use super::draw::normals;
use super::eigen::{dot, eigen};
use rand_chacha::ChaCha8Rng;

/// Rates and weights for a size of population.
pub(super) struct Rates {
    /// Recombination weights, best first, (49) to (53).
    weights: Vec<f64>,
    /// Parents.
    parents: usize,
    effective: f64,
    path: f64,
    sigma_path: f64,
    one: f64,
    many: f64,
    damping: f64,
    /// Mean length of a normal vector.
    length: f64,
    /// Generations between decompositions.
    pause: u64,
}

impl Rates {
    pub fn new(n: usize, population: usize, active: bool) -> Self {
        let d = n as f64;
        let raw: Vec<f64> = (1..=population).map(|i| f64::midpoint(population as f64, 1.0).ln() - (i as f64).ln()).collect(); // (49)
        let parents = population / 2;
        let mass = |w: &[f64]| w.iter().sum::<f64>().powi(2) / w.iter().map(|w| w * w).sum::<f64>().max(f64::MIN_POSITIVE);
        let (effective, against) = (mass(&raw[..parents]), mass(&raw[parents..]));
        let one = 2.0 / ((d + 1.3).powi(2) + effective); // (57)
        let many = (1.0 - one).min(2.0 * (0.25 + effective + 1.0 / effective - 2.0) / ((d + 2.0).powi(2) + effective)); // (58)
        let sigma_path = (effective + 2.0) / (d + effective + 5.0); // (55)
        let most = (1.0 + one / many).min(1.0 + 2.0 * against / (against + 2.0)).min((1.0 - one - many) / (d * many)); // (50) to (52)
        let (gain, loss) = raw.iter().fold((0.0, 0.0), |(g, l), w| if *w > 0.0 { (g + w, l) } else { (g, l - w) });
        let scaled = |w: &f64| match (*w > 0.0, active) {
            (true, _) => w / gain,
            (false, true) if loss > 0.0 => w * most / loss,
            _ => 0.0,
        };
        Self {
            weights: raw.iter().map(scaled).collect(), // (53)
            parents,
            effective,
            path: (4.0 + effective / d) / (d + 4.0 + 2.0 * effective / d), // (56)
            sigma_path,
            one,
            many,
            damping: 1.0 + 2.0 * (((effective - 1.0) / (d + 1.0)).sqrt() - 1.0).max(0.0) + sigma_path, // (55)
            length: d.sqrt() * (1.0 - 1.0 / (4.0 * d) + 1.0 / (21.0 * d * d)),
            pause: (1.0 / (10.0 * d * (one + many))).max(1.0) as u64,
        }
    }
}

/// A normal distribution: mean, step and covariance.
pub(super) struct Distribution {
    pub mean: Vec<f64>,
    /// Step `sigma`.
    pub step: f64,
    covariance: Vec<f64>,
    /// Eigenvectors of the covariance as rows, and the roots of its eigenvalues.
    basis: Vec<f64>,
    roots: Vec<f64>,
    step_path: Vec<f64>,
    path: Vec<f64>,
    age: u64,
    decomposed: u64,
    rates: Rates,
}

impl Distribution {
    pub fn new(mean: Vec<f64>, step: f64, rates: Rates) -> Self {
        let n = mean.len();
        let unit: Vec<f64> = (0..n * n).map(|k| if k % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self {
            mean,
            step,
            covariance: unit.clone(),
            basis: unit,
            roots: vec![1.0; n],
            step_path: vec![0.0; n],
            path: vec![0.0; n],
            age: 0,
            decomposed: 0,
            rates,
        }
    }

    /// Draws a place, (38) to (40).
    pub fn draw(&self, out: &mut [f64], rng: &mut ChaCha8Rng) {
        let n = out.len();
        out.copy_from_slice(&self.mean);
        for k in (0..n).step_by(2) {
            for (row, z) in (k..n.min(k + 2)).zip(normals(rng)) {
                add(out, self.step * self.roots[row] * z, &self.basis[row * n..][..n]);
            }
        }
    }

    /// Learns from places, best first, (41) to (47).
    pub fn learn(&mut self, places: &[&[f64]]) {
        self.age += 1;
        let n = self.mean.len();
        let steps: Vec<Vec<f64>> = places.iter().map(|x| x.iter().zip(&self.mean).map(|(x, m)| (x - m) / self.step).collect()).collect();
        let mut mean = vec![0.0; n];
        steps.iter().zip(&self.rates.weights).take(self.rates.parents).for_each(|(y, w)| add(&mut mean, *w, y));
        add(&mut self.mean, self.step, &mean);
        let going = self.lengthen(&mean);
        self.adapt(&steps, going);
        let share = self.rates.sigma_path / self.rates.damping;
        self.step *= (share * (dot(&self.step_path, &self.step_path).sqrt() / self.rates.length - 1.0)).min(1.0).exp(); // (44)
        if self.age >= self.decomposed + self.rates.pause {
            self.decompose();
        }
    }

    /// Both evolution paths, (43) and (45); says whether the second goes on.
    fn lengthen(&mut self, mean: &[f64]) -> bool {
        let (r, n) = (&self.rates, mean.len());
        let (keep, take) = (1.0 - r.sigma_path, (r.sigma_path * (2.0 - r.sigma_path) * r.effective).sqrt());
        let white = self.whiten(mean);
        self.step_path.iter_mut().zip(&white).for_each(|(p, w)| *p = keep * *p + take * w);
        let fade = 1.0 - keep.powf(2.0 * self.age as f64);
        let going = (dot(&self.step_path, &self.step_path) / fade).sqrt() < (1.4 + 2.0 / (n as f64 + 1.0)) * r.length;
        let take = if going { (r.path * (2.0 - r.path) * r.effective).sqrt() } else { 0.0 };
        self.path.iter_mut().zip(mean).for_each(|(p, m)| *p = (1.0 - r.path) * *p + take * m);
        going
    }

    /// The step as the unit normal distribution has it.
    fn whiten(&self, step: &[f64]) -> Vec<f64> {
        let n = step.len();
        let mut white = vec![0.0; n];
        for (row, root) in self.basis.chunks(n).zip(&self.roots) {
            add(&mut white, dot(row, step) / root, row);
        }
        white
    }

    /// The covariance, (46) and (47).
    fn adapt(&mut self, steps: &[Vec<f64>], going: bool) {
        let (n, r) = (self.mean.len(), &self.rates);
        let lost = if going { 0.0 } else { r.path * (2.0 - r.path) };
        let keep = 1.0 + r.one * lost - r.one - r.many * r.weights.iter().sum::<f64>();
        let weighed = steps.iter().zip(&r.weights).filter(|(_, w)| **w != 0.0).map(|(y, w)| {
            let square = || self.basis.chunks(n).zip(&self.roots).map(|(row, root)| (dot(row, y) / root).powi(2)).sum::<f64>();
            (r.many * if *w > 0.0 { *w } else { w * n as f64 / square().max(f64::MIN_POSITIVE) }, y)
        });
        let all: Vec<(f64, &Vec<f64>)> = weighed.chain([(r.one, &self.path)]).collect();
        for i in 0..n {
            let (head, row) = self.covariance.split_at_mut(i * n);
            let row = &mut row[..=i];
            for c in row.iter_mut() {
                *c *= keep;
            }
            for (w, y) in &all {
                add(row, w * y[i], &y[..=i]);
            }
            for (j, c) in row[..i].iter().enumerate() {
                head[j * n + i] = *c;
            }
        }
    }

    fn decompose(&mut self) {
        self.decomposed = self.age;
        let n = self.mean.len();
        let values = eigen(&self.covariance, &mut self.basis, n);
        let most = values.iter().copied().fold(0.0, f64::max);
        self.roots = values.iter().map(|v| v.max(1e-14 * most).sqrt()).collect();
    }

    /// Takes the step back where the standard deviation along any number has grown beyond `most`.
    pub fn hold(&mut self, most: f64) {
        let n = self.mean.len();
        let widest = (0..n).map(|k| self.covariance[k * n + k]).fold(0.0, f64::max).sqrt();
        self.step = self.step.min(most / widest);
    }

    /// The largest standard deviation along any number.
    pub fn reach(&self) -> f64 {
        let n = self.mean.len();
        (0..n).map(|k| self.covariance[k * n + k].max(0.0).sqrt().max(self.path[k].abs())).fold(0.0, f64::max) * self.step
    }

    /// Is it too thin or broken to go on?
    pub fn degenerate(&self) -> bool {
        let (low, high) = self.roots.iter().fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(*r), h.max(*r)));
        !(high <= 1e7 * low && self.step.is_finite() && self.mean.iter().all(|m| m.is_finite()))
    }
}

/// Adds a multiple of a vector.
fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(t, w)| *t += factor * w);
}
