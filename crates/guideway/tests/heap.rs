//! How much memory one call of a colony takes at its peak. One test in a binary of its own: the allocator counts everything that the process does.

use guideway::context::{Budget, Context};
use guideway::plan;
use guideway::query::Query;
use guideway::world::{Bits, Grid, World};
use serde_json::Value;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts bytes that are in use, and the most there were.
struct Counting;

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

fn more(bytes: usize) {
    MOST.fetch_max(USED.fetch_add(bytes, Ordering::SeqCst) + bytes, Ordering::SeqCst);
}

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: as asked.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Ordering::SeqCst);
        // SAFETY: as asked.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Largest growth of one planning call on 512 x 512 cells, bytes.
const MOST_GROWTH: usize = 32 << 20;

/// 512 x 512 cells: rooms of 32 x 32 with doors, and one cell in ten blocked.
fn rooms() -> Arc<World> {
    let (mut bits, mut state) = (Bits::new(512, 512), 1u64);
    for (y, x) in (0..512u32).flat_map(|y| (0..512u32).map(move |x| (y, x))) {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let wall = (x % 32 == 0 && !(10..14).contains(&(y % 32))) || (y % 32 == 0 && !(18..22).contains(&(x % 32)));
        bits.set(x, y, x > 0 && y > 0 && (wall || (state >> 33).is_multiple_of(10)) && !(x % 32 < 2 && (10..14).contains(&(y % 32))));
    }
    bits.set(1, 1, false);
    bits.set(511, 511, false);
    bits.set(510, 510, false);
    Arc::new(World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).expect("a grid")))
}

#[test]
fn a_planning_call_on_512_x_512_takes_at_most_32_mb() {
    let world = rooms();
    let query = Query::new(world, [1.5, 1.5], [511.5, 511.5]);
    let corners = serde_json::json!({ "graph": "corners" });
    let methods = [("improved-aco", &corners), ("bidirectional-aco", &corners), ("bidirectional-aco", &Value::Null), ("improved-aco", &Value::Null)];
    for (name, parameters) in methods.into_iter().chain([("pso-aco", &Value::Null)]) {
        let planner = plan::planner(name, parameters.clone()).expect("a planner");
        // Later iterations walk where the earlier ones did.
        let budget = Budget { iterations: Some(30), ..Budget::default() };
        let mut ctx = Context::new(1).with_budget(budget).expect("a budget");
        let before = USED.load(Ordering::SeqCst);
        MOST.store(before, Ordering::SeqCst);
        let found = planner.plan(&query, &mut ctx).expect("a way");
        let growth = MOST.load(Ordering::SeqCst) - before;
        println!("{name}: {:.1} MB, {} m in {} iterations", growth as f64 / 1_048_576.0, found.cost, found.iterations);
        assert!(growth <= MOST_GROWTH, "{name} takes {growth} bytes");
    }
}
