//! What the lattice searches share: exact integer costs, search nodes, and the open list.

use super::jump::{Agenda, Buckets, Heap};
use std::collections::BinaryHeap;
use std::ops::Add;

/// Exact costs on the lattice as integers. A straight step costs `q`, a diagonal one `p`, where `p / q` is a convergent of the continued fraction of the square
/// root of 2. Two paths differ by `m` straight and `n` diagonal steps; the sign of `n p - m q` is the sign of `n sqrt(2) - m` for every `0 < n < q`, because a
/// fraction `m / n` between a convergent and its limit has a larger denominator than the convergent. So while a path has fewer than `q` diagonal
/// steps, comparing integers *is* comparing exact lengths, ties included.
pub(super) trait Cost: Copy + Ord + Add<Output = Self> + Default + Send + 'static {
    /// Entry of the open list: smaller cost first, then the younger node.
    type Key: Copy + Ord + Send;
    /// Open list of the jump point search.
    type Agenda: Agenda<Self>;
    /// `q`.
    const STRAIGHT: Self;
    /// `p`.
    const DIAGONAL: Self;
    /// Costs from here on are not exact.
    const LIMIT: Self;
    /// `n` times the cost.
    fn times(self, n: u32) -> Self;
    /// Key of node `id` with estimate `f`; the heap pops the largest key.
    fn key(f: Self, id: u32) -> Self::Key;
    /// Back from the key.
    fn split(key: Self::Key) -> (Self, u32);
}

/// Convergent 19601 / 13860. Every path shorter than 19601 cells is compared exactly, and sums of two costs fit.
impl Cost for u32 {
    type Key = u64;
    type Agenda = Buckets;
    const STRAIGHT: u32 = 13860;
    const DIAGONAL: u32 = 19601;
    const LIMIT: u32 = 13860 * 19601;
    #[inline]
    fn times(self, n: u32) -> Self {
        self * n
    }
    #[inline]
    fn key(f: Self, id: u32) -> u64 {
        u64::from(!f) << 32 | u64::from(id)
    }
    #[inline]
    fn split(key: u64) -> (Self, u32) {
        (!((key >> 32) as u32), key as u32)
    }
}

/// Convergent 1855077841 / 1311738121: exact for every map that is accepted (at most 2^28 cells).
impl Cost for u64 {
    type Key = u128;
    type Agenda = Heap<u64>;
    const STRAIGHT: u64 = 1_311_738_121;
    const DIAGONAL: u64 = 1_855_077_841;
    const LIMIT: u64 = 1 << 62;
    #[inline]
    fn times(self, n: u32) -> Self {
        self * u64::from(n)
    }
    #[inline]
    fn key(f: Self, id: u32) -> u128 {
        u128::from(!f) << 32 | u128::from(id)
    }
    #[inline]
    fn split(key: u128) -> (Self, u32) {
        (!((key >> 32) as u64), key as u32)
    }
}

/// Octile distance, the exact cost on an empty lattice.
#[inline]
pub(super) fn octile<C: Cost>(dx: u32, dy: u32) -> C {
    let (long, short) = if dx > dy { (dx, dy) } else { (dy, dx) };
    C::STRAIGHT.times(long - short) + C::DIAGONAL.times(short)
}

/// A node of the search tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<C> {
    /// Cost from the start.
    pub g: C,
    /// Where it is, in the numbering of the search.
    pub place: u32,
    /// Index of its parent; its own for the start.
    pub parent: u32,
    /// Directions in which it was entered, a bit each.
    pub entered: u8,
    /// Expanded already.
    pub closed: bool,
}

/// Nodes and open list of one search; kept between searches for its memory.
///
/// `slot` maps a place to its node. It is never cleared: an entry counts only if the node it names says so (the sparse set of
/// \[briggs1993\]), so starting a search costs nothing, whatever the size of the map.
pub(super) struct Open<C: Cost> {
    slot: Vec<u32>,
    pub(super) nodes: Vec<Node<C>>,
    heap: BinaryHeap<C::Key>,
    /// A cost reached [`Cost::LIMIT`] and was dropped: the result is void, use a wider cost.
    pub(super) overflow: bool,
}

impl<C: Cost> Default for Open<C> {
    fn default() -> Self {
        Self { slot: Vec::new(), nodes: Vec::new(), heap: BinaryHeap::new(), overflow: false }
    }
}

impl<C: Cost> Open<C> {
    /// An empty search over `places` places with its root.
    pub fn begin(&mut self, places: usize, root: u32) {
        if self.slot.len() != places {
            self.slot = vec![0; places];
        }
        self.nodes.clear();
        self.heap.clear();
        self.overflow = false;
        self.slot[root as usize] = 0;
        self.nodes.push(Node { g: C::default(), place: root, parent: 0, entered: 0, closed: false });
        self.heap.push(C::key(C::default(), 0));
    }

    /// Offers a way to `place` of cost `g` and estimated total `f` through node `parent`, entering by `entered`.
    #[inline]
    pub fn relax(&mut self, place: u32, g: C, f: C, parent: u32, entered: u8) {
        if f >= C::LIMIT {
            self.overflow = true;
            return;
        }
        let mut id = self.slot[place as usize];
        match self.nodes.get_mut(id as usize) {
            Some(node) if node.place == place => {
                if g >= node.g {
                    if g == node.g && !node.closed {
                        node.entered |= entered;
                    }
                    return;
                }
                *node = Node { g, place, parent, entered, closed: false };
            }
            _ => {
                id = self.nodes.len() as u32;
                self.slot[place as usize] = id;
                self.nodes.push(Node { g, place, parent, entered, closed: false });
            }
        }
        self.heap.push(C::key(f, id));
    }

    /// The open node with the smallest estimate, now closed; among equals the youngest.
    #[inline]
    pub fn pop(&mut self) -> Option<(C, u32)> {
        while let Some(key) = self.heap.pop() {
            let (f, id) = C::split(key);
            let node = &mut self.nodes[id as usize];
            if !node.closed {
                node.closed = true;
                return Some((f, id));
            }
        }
        None
    }

    /// The node at a place and its number, if the search came there.
    #[inline]
    pub fn find(&self, place: u32) -> Option<(u32, &Node<C>)> {
        let id = self.slot[place as usize];
        self.nodes.get(id as usize).filter(|node| node.place == place).map(|node| (id, node))
    }

    /// Places from the root to node `id`.
    pub fn trail(&self, mut id: u32) -> Vec<u32> {
        let mut places = vec![self.nodes[id as usize].place];
        while id != 0 {
            id = self.nodes[id as usize].parent;
            places.push(self.nodes[id as usize].place);
        }
        places.reverse();
        places
    }
}
