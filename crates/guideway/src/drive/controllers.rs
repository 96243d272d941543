//! Every controller, one line each.

use super::{Controller, Dwa, Predictive, Robot, Tracker};
use crate::error::PlanError;
use crate::plan::Parameter;
use crate::plan::refusal::refused;
use crate::world::World;
use serde_json::Value;
use std::sync::Arc;

/// What a controller knows from the start.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The static map.
    pub world: Arc<World>,
    /// The base.
    pub robot: Robot,
    /// Clearance the motion was planned with, m.
    pub clearance: f64,
}

/// Builds a controller from parameters as JSON.
pub type Build = fn(Value, &Setup) -> Result<Box<dyn Controller>, PlanError>;

/// One line of the registry.
pub struct ControllerEntry {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Where the method comes from (keys of `refs.bib`).
    pub source: &'static str,
    /// Parameters in order.
    pub parameters: &'static [Parameter],
    /// Default parameters as JSON.
    pub defaults: fn() -> Value,
    /// Builds the controller from parameters as JSON.
    pub build: Build,
}

macro_rules! controller {
    ($name:literal, $type:ty, $source:literal, $about:literal, [$(($p:literal, $a:literal)),* $(,)?]) => {
        ControllerEntry {
            name: $name,
            about: $about,
            source: $source,
            parameters: &[$(Parameter { name: $p, about: $a }),*],
            defaults: || serde_json::to_value(<$type>::default()).unwrap_or_default(),
            build: |value, setup| {
                let read = |value| serde_json::from_value::<$type>(value);
                let parameters = read(value.clone()).map_err(|e| refused($name, &value, |value| read(value).map(drop), &e))?;
                parameters.build(setup)
            },
        }
    };
}

/// Every controller; the first is the default.
pub const CONTROLLERS: &[ControllerEntry] = &[
    controller!(
        "predictive-dwa",
        Predictive,
        "fox1997, kanayama1990",
        "dynamic window steered by the planned motion; only commands from which a full stop stays free",
        [
            ("progress", "weight of the progress along the path"),
            ("deviation", "weight of the distance from the path, 1/m"),
            ("heading", "weight of the heading against the path, 1/rad"),
            ("near", "weight of nearness to movers"),
            ("risk", "weight of an expected contact that can still be avoided"),
            ("doubt", "weight of a stop that may come too late if a mover turns against the robot"),
            ("keep_on", "weight of keeping to the manoeuvre chosen before"),
            ("change", "weight of a change of the command, s/m"),
            ("period", "time after which a chosen manoeuvre may turn into a stop, s"),
            ("horizon", "prediction, s"),
            ("park", "time that the place of a stop must stay free, s"),
            ("hold", "time for which a chosen command is held before the next choice, s"),
            ("speeds", "sampled speeds"),
            ("turns", "sampled turn rates"),
            ("margin", "distance kept to static obstacles, m (null: half the planned clearance, 0.02 to 0.1)"),
            ("keep", "distance kept to movers, m"),
            ("growth", "growth of that distance with the time predicted, m/s"),
            ("trust", "trust in each observed pose against odometry, 0 to 1"),
            ("patience", "time without progress after which a new plan is asked for, s"),
        ]
    ),
    controller!(
        "dwa",
        Dwa,
        "fox1997",
        "classic dynamic window towards a point of the path ahead",
        [
            ("heading", "weight of the heading to the target"),
            ("dist", "weight of the free distance along the arc"),
            ("velocity", "weight of the speed"),
            ("period", "time in which a new speed must be reached, s"),
            ("horizon", "prediction, s"),
            ("reaction", "time that passes before braking begins, s"),
            ("speeds", "sampled speeds"),
            ("turns", "sampled turn rates"),
            ("safety", "distance kept to obstacles, m"),
            ("look_ahead", "the target is so far ahead on the path, m"),
            ("trust", "trust in each observed pose against odometry, 0 to 1"),
            ("patience", "time without progress after which a new plan is asked for, s"),
        ]
    ),
    controller!(
        "tracker",
        Tracker,
        "kanayama1990",
        "follows the timed motion, waits for movers on the path",
        [
            ("k_x", "gain along the heading, 1/s"),
            ("k_y", "gain across the heading, 1/m2"),
            ("k_theta", "gain of the heading, 1/m"),
            ("k_turn", "gain of the heading in turns in place, 1/s"),
            ("lead", "the reference speeds are read so far ahead, s"),
            ("trust", "trust in each observed pose against odometry, 0 to 1"),
            ("behind", "the clock slows when the robot is farther behind, m"),
            ("margin", "distance kept to movers ahead, m"),
            ("foresight", "prediction of movers beyond the braking time, s"),
            ("patience", "waiting time before a new plan is asked for, s"),
        ]
    ),
];

/// Builds a controller by name with parameters as a JSON object (missing ones take their defaults, `null` is an empty object).
/// # Errors
/// [`PlanError::BadParameter`] for an unknown controller or parameter, naming the valid ones, or a value out of range.
pub fn controller(name: &str, parameters: Value, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
    let Some(entry) = CONTROLLERS.iter().find(|e| e.name == name) else {
        let names: Vec<_> = CONTROLLERS.iter().map(|e| e.name).collect();
        return Err(PlanError::bad("controller", name, format!("one of {}", names.join(", "))));
    };
    let parameters = if parameters.is_null() { Value::Object(serde_json::Map::new()) } else { parameters };
    if let Value::Object(map) = &parameters
        && let Some(key) = map.keys().find(|k| !entry.parameters.iter().any(|p| p.name == **k))
    {
        let names: Vec<_> = entry.parameters.iter().map(|p| p.name).collect();
        return Err(PlanError::bad(format!("{name}.{key}"), "an unknown parameter", format!("parameters of {name}: {}", names.join(", "))));
    }
    (entry.build)(parameters, setup)
}

/// Refuses parameters that are negative, huge or no numbers.
pub(super) fn check(name: &str, parameters: &[(&str, f64)]) -> Result<(), PlanError> {
    match parameters.iter().find(|(_, v)| !(0.0..=1e6).contains(v)) {
        Some((key, value)) => Err(PlanError::bad(format!("{name}.{key}"), value, "a number from 0 to 1e6")),
        None => Ok(()),
    }
}

/// Refuses numbers of samples that are too few or too many.
pub(super) fn samples(name: &str, parameters: &[(&str, u32)]) -> Result<(), PlanError> {
    match parameters.iter().find(|(_, n)| !(2..=1001).contains(n)) {
        Some((key, value)) => Err(PlanError::bad(format!("{name}.{key}"), value, "2 to 1001")),
        None => Ok(()),
    }
}
