//! A slow reference for the time-optimal jerk-limited speed profile under a ceiling: sequential convex programming.
//!
//! Unknowns are the squared speeds `b` at the nodes of a grid that is dense at the ends, where the motion is at rest. Then the time is a convex
//! function, speed, acceleration (`b' / 2`) and deceleration are linear constraints, and the jerk `b'' sqrt(b) / 2` is bounded through the tangent
//! of `1 / sqrt(b)` at the last iterate, which lies below it: every iterate is feasible and each one is faster than the last. The convex
//! problems are solved by a logarithmic barrier with Newton steps on a five-diagonal matrix. Nothing here is shared with the planner.

/// Limits of the reference problem.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    pub length: f64,
    pub speed: f64,
    pub acceleration: f64,
    pub deceleration: f64,
    pub jerk: f64,
    /// Ceiling of the arc length, m/s.
    pub ceiling: &'a dyn Fn(f64) -> f64,
}

/// `left . b <= right` over the nodes `at - 1, at, at + 1`.
struct Row {
    at: usize,
    left: [f64; 3],
    right: f64,
}

struct Grid {
    s: Vec<f64>,
    /// Highest squared speed.
    cap: Vec<f64>,
    /// Weight of `1 / v` in the time.
    weight: Vec<f64>,
}

/// Share of the length over which the grid is cubic in its index at either end.
fn grade(u: f64) -> f64 {
    // Cubic at both ends, smooth and monotone: the integral of u^2 (1 - u)^2, scaled to 1.
    u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
}

fn grid(p: &Problem, n: usize) -> Grid {
    // Half graded, half uniform would lose the ends; the pure grade keeps enough nodes in the middle.
    let s: Vec<f64> = (0..=n).map(|i| p.length * grade(i as f64 / n as f64)).collect();
    // From rest at zero acceleration no motion is faster than that of constant jerk.
    let from_rest = |x: f64| 0.25 * p.jerk * p.jerk * (6.0 * x / p.jerk).powf(4.0 / 3.0);
    let cap = s.iter().map(|x| (p.ceiling)(*x).min(p.speed).powi(2).min(from_rest(*x)).min(from_rest(p.length - x))).collect();
    let mut weight = vec![0.0; n + 1];
    for i in 1..n {
        weight[i] = 0.5 * (s[i + 1] - s[i - 1]);
    }
    // From rest with constant jerk v grows like s^(2/3): the first cell takes 3 h / v.
    weight[1] += 2.5 * (s[1] - s[0]);
    weight[n - 1] += 2.5 * (s[n] - s[n - 1]);
    Grid { s, cap, weight }
}

/// All constraints around the iterate `now`; interior nodes only, the ends are zero.
fn rows(p: &Problem, g: &Grid, now: &[f64]) -> Vec<Row> {
    let n = now.len() - 1;
    let mut rows = Vec::new();
    for (i, b) in now.iter().enumerate().take(n).skip(1) {
        rows.push(Row { at: i, left: [0.0, 1.0, 0.0], right: g.cap[i] });
        rows.push(Row { at: i, left: [0.0, -1.0, 0.0], right: 0.0 });
        let (h0, h1) = (g.s[i] - g.s[i - 1], g.s[i + 1] - g.s[i]);
        rows.push(Row { at: i, left: [-1.0, 1.0, 0.0], right: 2.0 * p.acceleration * h0 });
        rows.push(Row { at: i, left: [1.0, -1.0, 0.0], right: 2.0 * p.deceleration * h0 });
        if i == n - 1 {
            rows.push(Row { at: i, left: [0.0, 1.0, -1.0], right: 2.0 * p.deceleration * h1 });
        }
        let scale = 2.0 / (h0 + h1);
        let second = [scale / h0, -scale * (1.0 / h0 + 1.0 / h1), scale / h1];
        // |b''| <= 2 J / sqrt(b), the right side by its tangent at the iterate; multiplied by sqrt(b) of the iterate.
        let root = b.sqrt();
        let bend = p.jerk / b;
        for sign in [1.0, -1.0] {
            let left = [sign * second[0] * root, sign * second[1] * root + bend, sign * second[2] * root];
            rows.push(Row { at: i, left, right: 3.0 * p.jerk });
        }
    }
    rows
}

fn slack(row: &Row, b: &[f64]) -> f64 {
    row.right - (row.left[0] * b[row.at - 1] + row.left[1] * b[row.at] + row.left[2] * b[row.at + 1])
}

fn time(g: &Grid, b: &[f64]) -> f64 {
    (1..b.len() - 1).map(|i| g.weight[i] / b[i].sqrt()).sum()
}

fn barrier(g: &Grid, rows: &[Row], b: &[f64], t: f64) -> f64 {
    let mut value = t * time(g, b);
    for row in rows {
        let x = slack(row, b);
        if x.is_nan() || x <= 0.0 {
            return f64::INFINITY;
        }
        value -= x.ln();
    }
    value
}

/// One Newton direction of the barrier and its decrement.
fn direction(g: &Grid, rows: &[Row], b: &[f64], t: f64) -> (Vec<f64>, f64) {
    let n = b.len();
    let mut gradient = vec![0.0; n];
    // Lower band: band[i][k] is the entry (i, i - k).
    let mut band = vec![[0.0; 3]; n];
    for i in 1..n - 1 {
        gradient[i] -= 0.5 * t * g.weight[i] * b[i].powf(-1.5);
        band[i][0] += 0.75 * t * g.weight[i] * b[i].powf(-2.5);
    }
    for row in rows {
        let x = 1.0 / slack(row, b);
        for p in 0..3 {
            gradient[row.at + p - 1] += row.left[p] * x;
            for q in 0..=p {
                band[row.at + p - 1][p - q] += row.left[p] * row.left[q] * x * x;
            }
        }
    }
    // The ends are fixed.
    for i in [0, n - 1] {
        band[i] = [1.0, 0.0, 0.0];
        gradient[i] = 0.0;
    }
    band[1][1] = 0.0;
    band[2][2] = 0.0;
    band[n - 1][1] = 0.0;
    band[n - 1][2] = 0.0;
    let mut x: Vec<f64> = gradient.iter().map(|v| -v).collect();
    for i in 0..n {
        for k in (0..=2.min(i)).rev() {
            let j = i - k;
            let mut sum = band[i][k];
            for m in k + 1..=2.min(i) {
                if m - k <= 2 {
                    sum -= band[i][m] * band[j][m - k];
                }
            }
            band[i][k] = if k == 0 { sum.max(1e-300).sqrt() } else { sum / band[j][0] };
        }
    }
    for i in 0..n {
        let mut sum = x[i];
        for k in 1..=2.min(i) {
            sum -= band[i][k] * x[i - k];
        }
        x[i] = sum / band[i][0];
    }
    for i in (0..n).rev() {
        let mut sum = x[i];
        for k in 1..=2.min(n - 1 - i) {
            sum -= band[i + k][k] * x[i + k];
        }
        x[i] = sum / band[i][0];
    }
    let decrement = -gradient.iter().zip(&x).map(|(a, b)| a * b).sum::<f64>();
    (x, decrement)
}

/// Minimises the convex problem from a strictly feasible start.
fn solve(g: &Grid, rows: &[Row], start: &[f64]) -> Vec<f64> {
    let mut b = start.to_vec();
    let mut t = 10.0;
    while t < 2e7 {
        for _ in 0..25 {
            let (step, decrement) = direction(g, rows, &b, t);
            if decrement.is_nan() || decrement < 1e-4 {
                break;
            }
            let here = barrier(g, rows, &b, t);
            let mut size = 1.0;
            let next = loop {
                let next: Vec<f64> = b.iter().zip(&step).map(|(x, d)| x + size * d).collect();
                if barrier(g, rows, &next, t) <= here - 0.1 * size * decrement {
                    break Some(next);
                }
                size *= 0.5;
                if size < 1e-4 {
                    break None;
                }
            };
            match next {
                Some(next) => b = next,
                None => break,
            }
        }
        t *= 20.0;
    }
    b
}

/// A slow strictly feasible profile: `sin^4` in the index of the grid, lowered until every constraint holds with room.
fn slow(p: &Problem, g: &Grid) -> Vec<f64> {
    let n = g.s.len() - 1;
    // v = V x^2 (1 - x)^2-like in the index: b ~ s^(4/3) at the ends, as for constant jerk.
    let shape: Vec<f64> = (0..=n).map(|i| (std::f64::consts::PI * i as f64 / n as f64).sin().powi(4)).collect();
    let mut scale = 0.9 * p.speed * p.speed;
    for _ in 0..200 {
        let b: Vec<f64> = shape.iter().map(|x| scale * x).collect();
        if rows(p, g, &b).iter().all(|r| slack(r, &b) > 0.0) {
            return b;
        }
        scale *= 0.7;
    }
    panic!("no feasible start");
}

/// Least time over a grid of `n` cells, s, and the speeds (s in m, v in m/s) of the solution.
pub fn optimum(p: &Problem, n: usize) -> (f64, Vec<(f64, f64)>) {
    let g = grid(p, n);
    let mut b = slow(p, &g);
    let mut last = time(&g, &b);
    for _ in 0..25 {
        // A little inside, so that the barrier starts feasible.
        let inside: Vec<f64> = b.iter().map(|x| x * (1.0 - 1e-7)).collect();
        let around = rows(p, &g, &inside);
        if around.iter().any(|r| slack(r, &inside) <= 0.0) {
            break;
        }
        b = solve(&g, &around, &inside);
        let now = time(&g, &b);
        if now > last * (1.0 - 1e-4) {
            break;
        }
        last = now;
    }
    (time(&g, &b), g.s.iter().zip(&b).map(|(s, x)| (*s, x.max(0.0).sqrt())).collect())
}
