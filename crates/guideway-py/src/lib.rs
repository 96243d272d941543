//! Python binding: conversion only. Arrays come and go as NumPy, records as plain dictionaries, errors as the classes of `guideway.errors`.

mod axes;
mod certify;
mod convert;
mod errors;
mod exact;
mod minimize;
mod motion;
mod objective;
mod path;
mod pilot;
mod plan;
mod plant;
mod query;
mod refine;
mod scurve;
mod speed_map;
mod topp;
mod tour;
mod world;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python expects")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    #[pymodule_export]
    use crate::axes::{PointToPoint, PointToPointMotion, point_to_point};
    #[pymodule_export]
    use crate::certify::{certify, reference};
    #[pymodule_export]
    use crate::exact::{lattice_optimum, pareto};
    #[pymodule_export]
    use crate::minimize::{Minimum, minimize, optimizers};
    #[pymodule_export]
    use crate::motion::{Trajectory, ceiling, controllers, correct, drive, time};
    #[pymodule_export]
    use crate::path::Path;
    #[pymodule_export]
    use crate::pilot::Pilot;
    #[pymodule_export]
    use crate::plan::{Solution, advice, parameters, plan, planners, recommended};
    #[pymodule_export]
    use crate::query::Query;
    #[pymodule_export]
    use crate::refine::{Refined, measure, polyline, refine};
    #[pymodule_export]
    use crate::scurve::{Profile, scurve};
    #[pymodule_export]
    use crate::speed_map::SpeedMap;
    #[pymodule_export]
    use crate::topp::{JointMotion, time_joints, topp_kernel};
    #[pymodule_export]
    use crate::tour::tour;
    #[pymodule_export]
    use crate::world::{World, distance_transform};
}
