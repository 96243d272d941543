//! Roots of functions that grow, by steps of Newton, or of Halley where the curvature is known, inside a bracket.

/// The place in `[low, high]` where a growing function (value, slope, second derivative or 0) is zero; the end nearest to it if there is none.
pub(super) fn rising((mut low, mut high): (f64, f64), guess: f64, mut f: impl FnMut(f64) -> (f64, f64, f64)) -> f64 {
    let mut x = if guess > low && guess < high { guess } else { f64::midpoint(low, high) };
    let mut wide = high - low;
    for round in 0..200 {
        let (y, slope, bend) = f(x);
        if y == 0.0 {
            return x;
        }
        if y > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let mut next = x - y / (slope - 0.5 * y * bend / slope);
        // A step at least squares the relative error: one below 1e-9 is the last.
        if (next - x).abs() <= 1e-9 * x.abs() && next >= low && next <= high {
            return next;
        }
        // Every fourth step must have halved the bracket or be small beside it; otherwise it is halved by force.
        let slow = round % 4 == 3 && high - low > 0.5 * wide && (next - x).abs() > 1e-3 * (high - low);
        if round % 4 == 3 {
            wide = high - low;
        }
        if slow || !(next > low && next < high) {
            next = f64::midpoint(low, high);
        }
        if next <= low || next >= high {
            return next;
        }
        x = next;
    }
    x
}
