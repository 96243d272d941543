//! Exact and any-angle searches: planners themselves, and the references every other result is measured against.
