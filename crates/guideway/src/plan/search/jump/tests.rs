use super::agenda::{Agenda, Buckets, Heap};
use super::scan::CLEAR;
use super::{SEARCH, Scratch, search};
use crate::plan::search::{Ask, End, shortest_cells};
use crate::world::{Bits, Corners, Grid, Lattice, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn lattice(seed: u64) -> Arc<Lattice> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut bits = Bits::new(90, 80);
    for y in 0..80 {
        for x in 0..90 {
            bits.set(x, y, x + y > 0 && x + y < 168 && rng.random_bool(0.15));
        }
    }
    World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap()).lattice(0.0)
}

#[test]
fn buckets_pop_in_order_up_to_their_width() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut buckets, mut heap) = (Buckets::default(), Heap::<u32>::default());
    for round in 0..50 {
        let least = rng.random_range(0..1_000_000);
        Agenda::<u32>::begin(&mut buckets, least);
        Agenda::<u32>::begin(&mut heap, least);
        let mut now = least;
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for k in 0..200 {
            let f = now + rng.random_range(0..(round + 1) * 5000);
            buckets.push(f, f);
            heap.push(f, f);
            if k % 3 == 0 {
                let (bound, f) = buckets.pop().unwrap();
                assert!(bound <= f && f - bound < 2048);
                now = now.max(bound);
                a.push(f);
            }
        }
        a.extend(std::iter::from_fn(|| buckets.pop()).map(|(_, f)| f));
        b.extend(std::iter::from_fn(|| heap.pop()).map(|(_, f)| f));
        assert!(b.is_sorted());
        a.sort_unstable();
        assert_eq!(a, b);
    }
}

#[test]
fn a_graph_that_grew_too_large_is_forgotten_without_harm() {
    let lattice = lattice(6);
    let (ends, mut before, mut after) = ([[0, 0], [89, 79]], Vec::new(), Vec::new());
    let first = shortest_cells(&lattice, ends[0], ends[1], Corners::Clear, &mut before);
    assert!(first.is_some());
    let mut scratch = lattice.pool().take::<Scratch<u32, CLEAR, 4>>();
    assert!(scratch.graph.nodes.len() > 2);
    let long = scratch.graph.words.len() + 90 * 80 * 2 + (1 << 16);
    scratch.graph.words.resize(long, 0);
    lattice.pool().give(scratch);
    assert_eq!(shortest_cells(&lattice, ends[0], ends[1], Corners::Clear, &mut after), first);
    assert_eq!(before, after);
    assert!(lattice.pool().take::<Scratch<u32, CLEAR, 4>>().graph.words.len() < long);
}

#[test]
fn the_number_of_the_search_may_wrap_around() {
    let lattice = lattice(7);
    let (ends, mut turns) = ([[0, 0], [89, 79]], Vec::new());
    let first = shortest_cells(&lattice, ends[0], ends[1], Corners::Clear, &mut turns);
    let mut scratch = lattice.pool().take::<Scratch<u32, CLEAR, 4>>();
    scratch.search = 0u32.wrapping_sub(2 * SEARCH);
    scratch.graph.nodes.iter_mut().for_each(|n| n.state = 0);
    lattice.pool().give(scratch);
    for _ in 0..4 {
        assert_eq!(shortest_cells(&lattice, ends[0], ends[1], Corners::Clear, &mut turns), first);
    }
}

#[test]
fn a_long_search_can_be_stopped() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut bits = Bits::new(400, 400);
    for y in 0..400 {
        for x in 0..400 {
            bits.set(x, y, rng.random_bool(0.2));
        }
    }
    (0..400).for_each(|y| bits.set(398, y, true));
    bits.set(0, 0, false);
    bits.set(399, 399, false);
    let lattice = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap()).lattice(0.0);
    let (mut asked, mut out) = (0, Vec::new());
    let mut stop = || {
        asked += 1;
        asked == 2
    };
    let mut ask = Ask { lattice: &lattice, start: [0, 0], goal: [399, 399], corners: Corners::Clear, stop: &mut stop };
    assert!(matches!(search::<u32>(&mut ask, &mut out), End::Stopped));
    assert_eq!(asked, 2);
    assert_eq!(shortest_cells(&lattice, [0, 0], [399, 399], Corners::Clear, &mut out), None);
}
