use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Free cells within half a cell of the point in the middle of a piece between grid lines: one, or two on a line.
fn beside(free: &Bits, m: Point) -> Vec<[i32; 2]> {
    let near = |v: f64| {
        let f = v.floor() as i32;
        if (v - v.round()).abs() < 1e-12 { vec![v.round() as i32 - 1, v.round() as i32] } else { vec![f] }
    };
    let mut cells = Vec::new();
    for x in near(m[0]) {
        for y in near(m[1]) {
            if is_free(free, x, y) {
                cells.push([x, y]);
            }
        }
    }
    cells
}

fn is_gap(free: &Bits, x: i32, y: i32) -> bool {
    let [a, b, c, d] = [is_free(free, x - 1, y - 1), is_free(free, x, y - 1), is_free(free, x - 1, y), is_free(free, x, y)];
    a == d && b == c && a != b
}

/// Brute force: cuts the segment at every grid line and looks at each piece.
fn sees(free: &Bits, squeeze: bool, p: Point, q: Point) -> bool {
    let mut cuts = vec![0.0, 1.0];
    for k in 0..2 {
        let d = q[k] - p[k];
        if d != 0.0 {
            for line in p[k].min(q[k]).ceil() as i32..=p[k].max(q[k]).floor() as i32 {
                cuts.push(((f64::from(line) - p[k]) / d).clamp(0.0, 1.0));
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    let at = |t: f64| [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
    let mut before: Option<Vec<[i32; 2]>> = None;
    for w in cuts.windows(2) {
        let cells = beside(free, at(f64::midpoint(w[0], w[1])));
        if cells.is_empty() {
            return false;
        }
        if let Some(last) = before {
            let v = at(w[0]);
            let vertex = (v[0] - v[0].round()).abs() < 1e-9 && (v[1] - v[1].round()).abs() < 1e-9;
            let gap = vertex && is_gap(free, v[0].round() as i32, v[1].round() as i32);
            if gap && !squeeze && !cells.iter().any(|c| last.contains(c)) {
                return false;
            }
        }
        before = Some(cells);
    }
    true
}

/// Shortest path over the whole visibility graph of lattice points, start and goal; infinite if there is none.
fn brute(free: &Bits, squeeze: bool, start: Point, goal: Point) -> f64 {
    let mut points = vec![start, goal];
    for y in 0..=free.height() as i32 {
        for x in 0..=free.width() as i32 {
            if squeeze || !is_gap(free, x, y) {
                points.push([f64::from(x), f64::from(y)]);
            }
        }
    }
    let mut d = vec![f64::INFINITY; points.len()];
    let mut done = vec![false; points.len()];
    d[0] = 0.0;
    loop {
        let Some(i) = (0..points.len()).filter(|&i| !done[i] && d[i].is_finite()).min_by(|&a, &b| d[a].total_cmp(&d[b])) else {
            return f64::INFINITY;
        };
        if i == 1 {
            return d[1];
        }
        done[i] = true;
        for j in 0..points.len() {
            let g = d[i] + dist(points[i], points[j]);
            if !done[j] && g < d[j] && sees(free, squeeze, points[i], points[j]) {
                d[j] = g;
            }
        }
    }
}

fn random_map(rng: &mut ChaCha8Rng, size: u32, blocked: f64) -> Bits {
    let (w, h) = (rng.random_range(1..=size), rng.random_range(1..=size));
    let mut free = Bits::new(w, h);
    for y in 0..h {
        for x in 0..w {
            free.set(x, y, rng.random::<f64>() >= blocked);
        }
    }
    free
}

/// A point in a free cell: anywhere, on an edge, on a corner or at the centre.
fn random_point(rng: &mut ChaCha8Rng, free: &Bits) -> Option<Point> {
    for _ in 0..50 {
        let (x, y) = (rng.random_range(0..free.width()), rng.random_range(0..free.height()));
        if free.at(x, y) {
            let mut part = || match rng.random_range(0..4) {
                0 => 0.0,
                1 => 0.5,
                2 => 0.25,
                _ => rng.random::<f64>(),
            };
            return Some([f64::from(x) + part(), f64::from(y) + part()]);
        }
    }
    None
}

fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| dist(w[0], w[1])).sum()
}

fn agree(free: &Bits, squeeze: bool, start: Point, goal: Point) {
    let shown = || {
        let rows: Vec<String> =
            (0..free.height()).rev().map(|y| (0..free.width()).map(|x| if free.at(x, y) { '.' } else { '#' }).collect()).collect();
        format!("{}\n{start:?} -> {goal:?} squeeze {squeeze}", rows.join("\n"))
    };
    let truth = brute(free, squeeze, start, goal);
    match Rows::new(free, squeeze, start, goal).solve(&mut || false) {
        Found::Path(points) => {
            assert!((length(&points) - truth).abs() < 1e-9, "{} instead of {truth}\n{points:?}\n{}", length(&points), shown());
            for w in points.windows(2) {
                assert!(sees(free, true, w[0], w[1]), "{w:?} is not free\n{points:?}\n{}", shown());
            }
        }
        other => assert!(truth.is_infinite() && other == Found::Nothing, "{other:?} instead of {truth}\n{}", shown()),
    }
}

#[test]
fn equals_the_whole_visibility_graph() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut checked = 0;
    for i in 0..4000 {
        let size = [4, 6, 9, 12][i % 4];
        let free = random_map(&mut rng, size, [0.15, 0.3, 0.4, 0.5][i / 4 % 4]);
        if let (Some(start), Some(goal)) = (random_point(&mut rng, &free), random_point(&mut rng, &free)) {
            agree(&free, i % 3 == 0, start, goal);
            checked += 1;
        }
    }
    assert!(checked > 3500);
}

#[test]
fn one_square_by_hand() {
    let mut free = Bits::new(5, 5);
    for y in 0..5 {
        for x in 0..5 {
            free.set(x, y, x != 2 || y != 2);
        }
    }
    let Found::Path(points) = Rows::new(&free, false, [0.5, 2.5], [4.5, 2.5]).solve(&mut || false) else { panic!("no path") };
    let expected = 2.0 * 1.5f64.hypot(0.5) + 1.0;
    assert!((length(&points) - expected).abs() < 1e-12);
    assert_eq!(points.len(), 4);
}

#[test]
fn a_stopped_search_gives_a_lower_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut free = Bits::new(300, 300);
    for y in 0..300 {
        for x in 0..300 {
            free.set(x, y, rng.random::<f64>() >= 0.3);
        }
    }
    free.set(0, 0, true);
    free.set(299, 299, true);
    for k in 0..300 {
        free.set(k, 150, true);
        free.set(150, k, true);
        free.set(0, k, true);
        free.set(299, k, true);
    }
    let (start, goal) = ([0.5, 0.5], [299.5, 299.5]);
    let Found::Path(points) = Rows::new(&free, false, start, goal).solve(&mut || false) else { panic!("no path") };
    let Found::Stopped { bound } = Rows::new(&free, false, start, goal).solve(&mut || true) else { panic!("not stopped") };
    assert!(bound <= length(&points) && bound >= dist(start, goal) - 1e-9);
}
