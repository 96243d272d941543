//! Working memory that outlives a call, so that a search does not pay for fresh memory each time.

use std::any::Any;
use std::sync::{Mutex, PoisonError};

/// Idle scratch objects of any type. Calls take one and give it back; parallel calls each have their own.
#[derive(Default)]
pub struct Pool(Mutex<Vec<Box<dyn Any + Send>>>);

/// Idle objects kept at most; more parallel calls than that pay for fresh memory.
const KEPT: usize = 16;

impl Pool {
    /// An idle object of type `T`, or a new one.
    pub fn take<T: Any + Send + Default>(&self) -> Box<T> {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let found = idle.iter().rposition(|s| s.is::<T>()).map(|k| idle.swap_remove(k));
        drop(idle);
        found.and_then(|s| s.downcast().ok()).unwrap_or_default()
    }

    /// Keeps the object for the next call.
    pub fn give<T: Any + Send>(&self, scratch: Box<T>) {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if idle.len() < KEPT {
            idle.push(scratch);
        }
    }
}

impl std::fmt::Debug for Pool {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Pool")
    }
}
