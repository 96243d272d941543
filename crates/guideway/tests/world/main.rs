//! The world and the collision checker against brute force.

mod brute;
mod collision;
mod distance;
mod geometry;
