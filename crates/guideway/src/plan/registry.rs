//! The registry of planners.

use super::{Entry, colony, search};
use crate::entry;

/// Every planner, one line each.
pub const REGISTRY: &[Entry] = &[
    entry!("dijkstra", search::Dijkstra, true, "dijkstra1959", "Exact shortest lattice path, uninformed; the oracle of the other searches", []),
    entry!("astar", search::AStar, true, "hart1968", "Exact shortest lattice path by A* with the octile distance", []),
    entry!(
        "jump-point",
        search::JumpPoint,
        true,
        "harabor2011, harabor2014",
        "Exact shortest lattice path by bit-parallel jump point search; the fastest",
        []
    ),
    entry!(
        "lexicographic",
        search::Lexicographic,
        true,
        "hart1968",
        "Exact shortest lattice path with the fewest turns; least energy for heavy loads",
        []
    ),
    entry!("theta-star", search::ThetaStar, false, "daniel2010", "Any-angle path over the lattice, near the optimum", []),
    entry!("lazy-theta-star", search::LazyThetaStar, false, "nash2010", "Theta* that looks along a line only when it expands its end", []),
    entry!(
        "visibility",
        search::Visibility,
        false,
        "harabor2016, cui2017, lozano1979",
        "Exact any-angle optimum: tangents and arcs around everything in the way",
        []
    ),
    entry!(
        "aco",
        colony::Aco,
        true,
        "dorigo1996",
        "Ant system: every ant that arrives deposits; the baseline of the colonies",
        [
            ("preset", "default | paper"),
            ("ants", "ants of a generation"),
            ("iterations", "generations, if the budget names none"),
            ("alpha", "exponent of the pheromone"),
            ("beta", "exponent of the heuristic"),
            ("heuristic", "visibility of a neighbour: goal | detour | step"),
            ("evaporation", "share of the pheromone that evaporates in a generation"),
            ("deposit", "pheromone that an ant spreads over its way, times its length in cells"),
            ("initial", "initial pheromone"),
            ("loop_cutting", "cut loops out of the ways of ants"),
        ],
        paper
    ),
    entry!(
        "mmas",
        colony::Mmas,
        true,
        "stutzle2000",
        "Max-min ant system: only the best ant deposits, the pheromone stays between bounds",
        [
            ("preset", "default | paper"),
            ("ants", "ants of a generation"),
            ("iterations", "generations, if the budget names none"),
            ("alpha", "exponent of the pheromone"),
            ("beta", "exponent of the heuristic"),
            ("heuristic", "visibility of a neighbour: goal | detour | step"),
            ("evaporation", "share of the pheromone that evaporates in a generation"),
            ("best_probability", "probability of the best trail after convergence; sets the lower bound"),
            ("elite_every", "every so many generations the best so far deposits"),
            ("stagnation", "generations of equal trails before the pheromone is smoothed"),
            ("loop_cutting", "cut loops out of the ways of ants"),
        ],
        paper
    ),
    entry!(
        "bidirectional-aco",
        colony::BidirectionalAco,
        true,
        "han2024",
        "Ants walk there and back, with a heuristic of its own in each direction",
        [
            ("preset", "default | paper"),
            ("ants", "ants of half an iteration"),
            ("iterations", "iterations, there and back, if the budget names none"),
            ("patience", "iterations without improvement after which it stops"),
            ("alpha", "exponent of the pheromone"),
            ("beta", "exponent of the heuristic"),
            ("evaporation", "share of the pheromone that evaporates in half an iteration"),
            ("deposit", "pheromone that an ant spreads over its way, times its length in cells"),
            ("initial", "initial pheromone"),
            ("least", "least pheromone"),
            ("most", "largest pheromone"),
            ("seeding", "a trail to begin with: off | any-angle | exact"),
            ("loop_cutting", "cut loops out of the ways of ants"),
            ("elitist", "the best so far deposits in every half"),
            ("polish", "iterations without improvement after which local search works on the best trails; 0: never"),
            ("restart", "entropy of the choices along the best trail, 0 to 1, below which the pheromone starts anew; 0: never"),
        ],
        paper
    ),
];
