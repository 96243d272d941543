//! Every controller, one line each.

use super::{Controller, Dwa, ImprovedDwa, Robot, Tracker};
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
    /// Parameters of `preset=paper` as JSON, where there are presets.
    pub paper: Option<fn() -> Value>,
    /// Builds the controller from parameters as JSON.
    pub build: Build,
}

macro_rules! controller {
    ($name:literal, $type:ty, $source:literal, $about:literal, $parameters:tt, paper) => {
        ControllerEntry {
            paper: Some(|| serde_json::to_value(<$type>::paper()).unwrap_or_default()),
            ..controller!($name, $type, $source, $about, $parameters)
        }
    };
    ($name:literal, $type:ty, $source:literal, $about:literal, [$(($p:literal, $a:literal)),* $(,)?]) => {
        ControllerEntry {
            name: $name,
            about: $about,
            source: $source,
            parameters: &[$(Parameter { name: $p, about: $a }),*],
            defaults: || serde_json::to_value(<$type>::default()).unwrap_or_default(),
            paper: None,
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
        "improved-dwa",
        ImprovedDwa,
        "lu2025, fox1997, bouraine2012",
        "dynamic window that looks ahead in (place, time); only commands after which a full brake is certain to be in time",
        [
            ("preset", "default | paper: our settings or those of the source"),
            ("heading", "weight of the heading to the sub-goal"),
            ("dist", "weight of the free distance along the arc"),
            ("velocity", "weight of the speed"),
            ("path", "weight of the agreement with the direction of the path"),
            ("to_go", "weight of the time to the goal that is left at the end of the prediction, 1/s"),
            ("deviation", "weight of the distance from the path over time, 1/(m s)"),
            ("near", "weight of nearness to movers over time, 1/s"),
            ("exposed", "weight of standing in the way of movers over time, 1/s"),
            ("turned", "weight of standing in the way of movers that turn around, over time, 1/s"),
            ("change", "weight of a change of the command, s/m"),
            ("keep_on", "weight of keeping to the side chosen before"),
            ("period", "control period, s: the window of the source, and how long a command may act in the guarantee"),
            ("horizon", "prediction, s"),
            ("safety", "distance kept to obstacles, m (null: to static ones half the planned clearance, 0.02 to 0.1 m, to movers 0.1 m)"),
            ("speed_step", "steps of the sampled speeds, m/s (preset=paper)"),
            ("turn_step", "steps of the sampled turn rates, rad/s (preset=paper)"),
            ("emergency", "above this speed the robot brakes when obstacles are nearer than safety, below it turns in place, m/s (preset=paper)"),
            ("room", "free | least | mean | end: what dist is (preset=paper)"),
            ("far", "distances count up to this in dist, m (preset=paper)"),
            ("divide", "sum | scale: what the scores of a critic are divided by (preset=paper)"),
            ("aim", "the heading to the sub-goal is judged so long ahead, s (preset=paper)"),
            ("centred", "safety is measured from the reference point, not from the hull (preset=paper)"),
            ("pivot", "below emergency, nearer than safety: turn in place towards the sub-goal, else the window goes on (preset=paper)"),
            ("clear", "arcs on which anything is met within the horizon are out, else those without room to stop (preset=paper)"),
            ("guarantee", "only commands after which a full brake ends before anything can be met"),
            ("jerk_limited", "commanded speeds keep to the jerk of the robot, but for emergencies"),
            ("error", "bound of the error of pose and model, m"),
            ("drift", "growth of that bound with the distance driven"),
            ("lag_speed", "time constant of the speed, s"),
            ("lag_turn", "time constant of the turn rate, s"),
            ("delay", "time until a command reaches the actuators, s"),
            ("growth", "growth of the distance kept to movers with the time predicted, m/s"),
            ("beam", "plans kept in the search"),
            ("reverse", "speed of driving backwards to get out of the way, m/s (0: never)"),
            ("trust", "trust in each observed pose against odometry, 0 to 1"),
            ("patience", "time without progress after which a new plan is asked for, s"),
        ],
        paper
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
            ("centred", "safety is measured from the reference point, not from the hull"),
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

/// Builds a controller by name with parameters as a JSON object (missing ones take the values of the preset, `null` is an empty object).
/// # Errors
/// [`PlanError::BadParameter`] for an unknown controller or parameter, naming the valid ones, or a value out of range.
pub fn controller(name: &str, parameters: Value, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
    let Some(entry) = CONTROLLERS.iter().find(|e| e.name == name) else {
        let names: Vec<_> = CONTROLLERS.iter().map(|e| e.name).collect();
        return Err(PlanError::bad("controller", name, format!("one of {}", names.join(", "))));
    };
    let given = match parameters {
        Value::Null => serde_json::Map::new(),
        Value::Object(map) => map,
        other => return Err(PlanError::bad(name, other, "a table of parameters")),
    };
    if let Some(key) = given.keys().find(|k| !entry.parameters.iter().any(|p| p.name == **k)) {
        let names: Vec<_> = entry.parameters.iter().map(|p| p.name).collect();
        return Err(PlanError::bad(format!("{name}.{key}"), "an unknown parameter", format!("parameters of {name}: {}", names.join(", "))));
    }
    let base = match (entry.paper, given.get("preset").and_then(Value::as_str)) {
        (Some(paper), Some("paper")) => paper(),
        _ => (entry.defaults)(),
    };
    let mut all = base.as_object().cloned().unwrap_or_default();
    all.extend(given);
    (entry.build)(Value::Object(all), setup)
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
