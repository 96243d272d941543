//! Exact lattice references against plain relaxation, and the numbers of the stand-in scenes.

mod brute;
mod lexicographic;
mod pareto;
