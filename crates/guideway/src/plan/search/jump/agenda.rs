//! Open lists of the jump point search.

use super::super::open::Cost;
use std::collections::BinaryHeap;

/// Nodes to expand, those with small estimates first.
pub(in super::super) trait Agenda<C>: Default + Send + 'static {
    /// Empties the list. No estimate will be below `least`, nor clearly below one that was popped.
    fn begin(&mut self, least: C);
    /// Adds a node with estimate `f`.
    fn push(&mut self, f: C, node: u32);
    /// The next node and a lower bound of all estimates in the list.
    fn pop(&mut self) -> Option<(C, u32)>;
}

/// Exact order; among equals the youngest entry first.
pub(in super::super) struct Heap<C: Cost> {
    keys: BinaryHeap<C::Key>,
    /// Nodes in the order in which they came: ties go by age, never by what earlier searches have seen.
    entries: Vec<u32>,
}

impl<C: Cost> Default for Heap<C> {
    fn default() -> Self {
        Self { keys: BinaryHeap::new(), entries: Vec::new() }
    }
}

impl<C: Cost> Agenda<C> for Heap<C> {
    fn begin(&mut self, _least: C) {
        self.keys.clear();
        self.entries.clear();
    }
    fn push(&mut self, f: C, node: u32) {
        self.keys.push(C::key(f, self.entries.len() as u32));
        self.entries.push(node);
    }
    fn pop(&mut self) -> Option<(C, u32)> {
        let (f, entry) = C::split(self.keys.pop()?);
        Some((f, self.entries[entry as usize]))
    }
}

/// Buckets of estimates, `1 << WIDTH` cost units (a seventh of a straight step) wide; within one the youngest entry first. The order is not exact, so a
/// node may be expanded again with a smaller cost; the result is exact all the same, because the search goes on to the end of the goal's bucket.
#[derive(Default)]
pub(in super::super) struct Buckets {
    least: u32,
    /// A bit for each bucket that is not empty.
    full: Vec<u64>,
    /// Youngest entry of each bucket; valid where the bit is set.
    heads: Vec<u32>,
    /// Node and next older entry of the bucket, or `LAST`.
    entries: Vec<[u32; 2]>,
    /// Word of `full` before which all are empty.
    word: usize,
}

const WIDTH: u32 = 11;
const LAST: u32 = u32::MAX;

impl Agenda<u32> for Buckets {
    fn begin(&mut self, least: u32) {
        self.full.iter_mut().for_each(|word| *word = 0);
        self.entries.clear();
        (self.least, self.word) = (least, 0);
    }

    #[inline]
    fn push(&mut self, f: u32, node: u32) {
        let bucket = ((f - self.least) >> WIDTH) as usize;
        if bucket >= self.heads.len() {
            self.full.resize((bucket / 64 + 1) * 2, 0);
            self.heads.resize(self.full.len() * 64, LAST);
        }
        let (word, bit) = (&mut self.full[bucket / 64], 1 << (bucket % 64));
        let next = if *word & bit == 0 { LAST } else { self.heads[bucket] };
        *word |= bit;
        self.heads[bucket] = self.entries.len() as u32;
        self.entries.push([node, next]);
    }

    #[inline]
    fn pop(&mut self) -> Option<(u32, u32)> {
        while *self.full.get(self.word)? == 0 {
            self.word += 1;
        }
        let word = &mut self.full[self.word];
        let bucket = self.word * 64 + word.trailing_zeros() as usize;
        let [node, next] = self.entries[self.heads[bucket] as usize];
        if next == LAST {
            *word &= *word - 1;
        } else {
            self.heads[bucket] = next;
        }
        Some((self.least + ((bucket as u32) << WIDTH), node))
    }
}
