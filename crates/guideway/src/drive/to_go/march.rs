//! Fast marching with a queue of buckets.

/// Values this near are the same (cells, as a share of the value): a fall below it is rounding.
const SAME: f32 = 1e-6;
/// Width of a bucket, cells.
const WIDTH: f32 = 0.7;

/// Lowers `cost` from the seeds (index, value) to the fixed point of the upwind scheme with the slowness `slow`, both padded by a frame of infinities, `stride` apart row to
/// row.
pub(super) fn march(cost: &mut [f32], slow: &[f32], stride: usize, seeds: &[(usize, f32)]) {
    let steepest = slow.iter().copied().filter(|f| f.is_finite()).fold(1.0, f32::max);
    let farthest = seeds.iter().map(|s| s.1).fold(0.0, f32::max);
    // No value in the queue is farther above the current bucket than a step or a seed.
    let mut buckets: Vec<Vec<(u32, f32)>> = vec![Vec::new(); (steepest.max(farthest) / WIDTH) as usize + 3];
    let n = buckets.len();
    let place = |value: f32| (value / WIDTH) as usize % n;
    let mut waiting = 0;
    for &(i, value) in seeds {
        cost[i] = value;
        buckets[place(value)].push((i as u32, value));
        waiting += 1;
    }
    let (mut current, mut batch) = (0, Vec::new());
    while waiting > 0 {
        std::mem::swap(&mut batch, &mut buckets[current % n]);
        if batch.is_empty() {
            current += 1;
            continue;
        }
        waiting -= batch.len();
        for (i, value) in batch.drain(..) {
            let i = i as usize;
            if cost[i] < value {
                continue;
            }
            for k in [i - 1, i + 1, i - stride, i + stride] {
                // Nothing falls because of a neighbour above it.
                if cost[k] <= value || slow[k].is_infinite() {
                    continue;
                }
                let next = upwind(cost[k - 1].min(cost[k + 1]), cost[k - stride].min(cost[k + stride]), slow[k]);
                if next < cost[k] - SAME * next {
                    cost[k] = next;
                    buckets[place(next)].push((k as u32, next));
                    waiting += 1;
                }
            }
        }
    }
}

/// The value of a cell from the least of its neighbours on either axis.
#[inline]
pub(super) fn upwind(a: f32, b: f32, slow: f32) -> f32 {
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    let gap = high - low;
    if gap >= slow { low + slow } else { 0.5 * (low + high + (2.0 * slow * slow - gap * gap).sqrt()) }
}
