//! The registry of optimizers.

use super::{CmaEs, De, Firefly, GroupedPso, ImprovedDe, LShade, Optimizer, Pso, Sparrow};
use crate::error::PlanError;
use serde_json::{Map, Value};

/// One parameter of a method, for `--list`.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Field name.
    pub name: &'static str,
    /// What it is, its unit and its source.
    pub about: &'static str,
}

/// One line of the registry.
pub struct Entry {
    /// Name in files and in Python.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Where the method comes from (keys of `refs.bib`).
    pub source: &'static str,
    /// Parameters in order.
    pub parameters: &'static [Parameter],
    /// Default parameters as JSON.
    pub defaults: fn() -> Value,
    /// Builds the optimizer from parameters as JSON.
    pub build: fn(Value) -> Result<Box<dyn Optimizer>, serde_json::Error>,
}

macro_rules! entry {
    ($name:literal, $type:ty, $source:literal, $about:literal, [$(($p:literal, $a:literal)),* $(,)?]) => {
        Entry {
            name: $name,
            about: $about,
            source: $source,
            parameters: &[$(Parameter { name: $p, about: $a }),*],
            defaults: || serde_json::to_value(<$type>::default()).unwrap_or_default(),
            build: |value| Ok(Box::new(serde_json::from_value::<$type>(value)?)),
        }
    };
}

/// Every optimizer, one line each.
pub const REGISTRY: &[Entry] = &[
    entry!(
        "l-shade",
        LShade,
        "tanabe2014",
        "Differential evolution that learns its parameters, with an archive and a shrinking population; the default",
        [
            ("population", "individuals at first; 0: 18 for each number, at most a 150th of the evaluations"),
            ("least", "individuals in the end"),
            ("iterations", "generations, if the budget names neither iterations nor evaluations"),
            ("memory", "entries of the memory of what succeeded"),
            ("elite", "share of the population whose members guide"),
            ("archive", "size of the archive of beaten parents, in populations"),
            ("opposition", "the first population is random places and their opposites"),
            ("prior", "one entry of the memory has the decaying scale of improved-de"),
            ("patience", "generations without improvement after which it stops; 0: never"),
            ("tolerance", "share of each side of the box; it stops once the population spans no more; 0: never"),
        ]
    ),
    entry!(
        "cma-es",
        CmaEs,
        "hansen2016, auger2005, hansen2009",
        "Covariance matrix adaptation with restarts; the most exact on smooth functions and narrow valleys",
        [
            ("population", "individuals of the first run; 0: by the number of numbers"),
            ("iterations", "generations of all runs, if the budget names neither iterations nor evaluations"),
            ("step", "standard deviation at first, share of each side of the box"),
            ("hint_step", "the same for the first run if there are hints"),
            ("restarts", "what follows a run that has ended: off | ipop | bipop"),
            ("growth", "factor of the population from large run to large run"),
            ("active", "the worse half of a generation counts too"),
            ("tolerance", "share of each side of the box; a run ends once it spans no more"),
            ("patience", "generations without improvement after which it stops; 0: never"),
        ]
    ),
    entry!(
        "de",
        De,
        "storn1997",
        "Differential evolution, rand/1/bin; the baseline",
        [
            ("population", "individuals"),
            ("iterations", "generations, if the budget names neither iterations nor evaluations"),
            ("scale", "scale factor F"),
            ("crossover", "crossover rate CR"),
            ("patience", "generations without improvement after which it stops; 0: never"),
            ("tolerance", "share of each side of the box; it stops once the population spans no more; 0: never"),
        ]
    ),
    entry!(
        "improved-de",
        ImprovedDe,
        "storn1997, rahnamayan2008",
        "Differential evolution with opposition, a decaying scale, a growing crossover rate and restarts",
        [
            ("population", "individuals"),
            ("iterations", "generations, if the budget names neither iterations nor evaluations"),
            ("opposition", "what is reflected for the first population: off | full | quartiles"),
            ("form", "form of the scale factor: default (from first to last) | literal (from twice the last to the last)"),
            ("scale_range", "scale factor F, [first, last]"),
            ("crossover_range", "crossover rate CR, [first, last]"),
            ("stagnation", "generations without improvement after which the worst are renewed; 0: never"),
            ("renewed", "share of the population that is renewed then"),
            ("renewal", "what takes their place: opposite | random | both"),
            ("patience", "generations without improvement after which it stops; 0: never"),
            ("tolerance", "share of each side of the box; it stops once the population spans no more; 0: never"),
        ]
    ),
    entry!(
        "firefly",
        Firefly,
        "yang2009",
        "Fireflies fly towards all that are brighter; a baseline",
        [
            ("population", "fireflies"),
            ("iterations", "generations, if the budget names neither iterations nor evaluations"),
            ("attractiveness", "attractiveness at no distance"),
            ("absorption", "how fast it fades with the square of the distance in the unit cube"),
            ("step", "random step at first, share of each side of the box"),
            ("fading", "factor of the random step per generation"),
            ("patience", "generations without improvement after which it stops; 0: never"),
        ]
    ),
    entry!(
        "pso",
        Pso,
        "kennedy1995, shi1998",
        "Particle swarm with an inertia weight",
        [
            ("particles", "particles"),
            ("iterations", "iterations at most"),
            ("inertia", "inertia"),
            ("cognitive", "pull of the particle's own best place"),
            ("social", "pull of the best place of all"),
            ("speed", "largest step in each number, share of its range"),
            ("patience", "iterations without improvement after which it stops; 0: never"),
        ]
    ),
    entry!(
        "grouped-pso",
        GroupedPso,
        "han2024",
        "Particle swarm in groups with an elite and a second, adaptive stage",
        [
            ("particles", "particles besides the elite"),
            ("groups", "subgroups"),
            ("iterations", "iterations at most"),
            ("patience", "iterations without improvement after which it stops; 0: never"),
            ("regroup", "subgroups are dealt anew after that many iterations; 0: never"),
            ("elite", "elite group"),
            ("second_stage", "second, adaptive stage for particles that the first does not improve"),
            ("inertia", "inertia of the first stage"),
            ("cognitive", "pull of the own best place in the first stage"),
            ("social", "pull of the guide in the first stage"),
            ("inertia_range", "inertia of the second stage, [at the guide, farthest from it]"),
            ("cognitive_range", "pull of the own best place in the second stage, [first, last]"),
            ("social_range", "pull of the guide in the second stage, [first, last]"),
            ("speed", "largest step in each number, share of its range"),
        ]
    ),
    entry!(
        "sparrow",
        Sparrow,
        "xue2020",
        "Sparrow search; drawn to 0, wherever the minimum is",
        [
            ("sparrows", "sparrows"),
            ("iterations", "iterations at most"),
            ("producers", "share of producers"),
            ("scouts", "share of scouts"),
            ("safety", "producers wander while the alarm is below it"),
            ("patience", "iterations without improvement after which it stops; 0: never"),
        ]
    ),
];

/// Builds an optimizer by name with parameters as a JSON object (missing ones take the defaults).
/// # Errors
/// [`PlanError::BadParameter`] for an unknown optimizer or parameter, naming the valid ones.
pub fn optimizer(name: &str, parameters: Value) -> Result<Box<dyn Optimizer>, PlanError> {
    let Some(entry) = REGISTRY.iter().find(|e| e.name == name) else {
        let names: Vec<_> = REGISTRY.iter().map(|e| e.name).collect();
        return Err(PlanError::bad("optimizer", name, format!("one of {}", names.join(", "))));
    };
    let given = match parameters {
        Value::Null => Map::new(),
        Value::Object(map) => map,
        other => return Err(PlanError::bad(name, other, "a table of parameters")),
    };
    if let Some(key) = given.keys().find(|k| !entry.parameters.iter().any(|p| p.name == **k)) {
        let names: Vec<_> = entry.parameters.iter().map(|p| p.name).collect();
        return Err(PlanError::bad(format!("{name}.{key}"), "an unknown parameter", format!("parameters of {name}: {}", names.join(", "))));
    }
    for (key, value) in &given {
        let alone = Map::from_iter([(key.clone(), value.clone())]);
        (entry.build)(Value::Object(alone)).map_err(|e| PlanError::bad(format!("{name}.{key}"), value, e.to_string()))?;
    }
    (entry.build)(Value::Object(given)).map_err(|e| PlanError::bad(name, "its parameters", e.to_string()))
}
