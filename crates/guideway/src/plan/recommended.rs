//! `preset=recommended`: parameters by the map of the query, as searches found them and maps that they had not seen confirmed (`docs/guidance.md`).

use super::{Planner, Solution, planner};
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use serde_json::{Map, Value, json};

/// Parameters that are better than the defaults of a planner on maps of a kind.
pub struct Advice {
    /// Name of the planner.
    pub planner: &'static str,
    /// The maps, in words.
    pub place: &'static str,
    /// Share of blocked cells of the grid from which on it holds, 0 to 1.
    pub least_share: f64,
    /// The parameters as JSON.
    pub set: fn() -> Value,
    /// Name of the experiment that shows it.
    pub evidence: &'static str,
}

/// What is recommended beside the defaults. Planners that are not here keep theirs: for them a search found nothing that held on other maps.
pub static ADVICE: &[Advice] = &[
    Advice {
        planner: "pso-aco",
        place: "grids with 20 % or more of their cells blocked, and mazes",
        least_share: 0.2,
        set: || json!({"particles": 50, "swarm_iterations": 5, "ants": 40, "beta": 9.0, "evaporation": 0.2}),
        evidence: "guide-pso-aco",
    },
    Advice {
        planner: "improved-aco",
        place: "grids of every kind that was looked at",
        least_share: 0.0,
        set: || json!({"ants": 40, "beta": 16.0, "evaporation": 0.05, "o3": false, "polish": 2, "horizon": 15.0}),
        evidence: "guide-improved-aco",
    },
];

/// Parameters recommended for a planner on the map of a query; none where the defaults are the best that is known.
pub fn recommended(planner: &str, query: &Query) -> Map<String, Value> {
    let Some(grid) = query.world.grid() else { return Map::new() };
    let blocked = grid.blocked();
    let share = blocked.count() as f64 / (f64::from(blocked.width()) * f64::from(blocked.height()));
    let advice = ADVICE.iter().find(|advice| advice.planner == planner && share >= advice.least_share);
    advice.and_then(|advice| (advice.set)().as_object().cloned()).unwrap_or_default()
}

/// Is it `preset=recommended` that the parameters ask for?
pub(super) fn asked(parameters: &Value) -> bool {
    parameters.get("preset").and_then(Value::as_str) == Some("recommended")
}

/// The parameters for this query: what is recommended in place of the preset, those given before it.
pub(super) fn settled(planner: &str, mut given: Value, query: &Query) -> Value {
    if asked(&given)
        && let Some(given) = given.as_object_mut()
    {
        given.remove("preset");
        for (key, value) in recommended(planner, query) {
            given.entry(key).or_insert(value);
        }
    }
    given
}

/// A planner that takes its parameters from the map.
pub(super) struct Recommended {
    pub(super) name: &'static str,
    pub(super) given: Value,
}

impl Recommended {
    fn on(&self, query: &Query) -> Result<Box<dyn Planner>, PlanError> {
        planner(self.name, settled(self.name, self.given.clone(), query))
    }
}

impl Planner for Recommended {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.on(query)?.plan(query, ctx)
    }

    fn replan(&self, previous: &Solution, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.on(query)?.replan(previous, query, ctx)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Budget;
    use crate::plan::{REGISTRY, parameters, parameters_for};
    use crate::world::{Bits, Grid, World};
    use std::sync::Arc;

    /// 20 x 20 cells with a free frame and every `step`-th cell inside blocked.
    fn query(step: u32) -> Query {
        let mut blocked = Bits::new(20, 20);
        (1..19).flat_map(|y| (1..19).map(move |x| (x, y))).filter(|(x, y)| (x + y) % step == 0).for_each(|(x, y)| blocked.set(x, y, true));
        let world = World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap());
        Query::new(Arc::new(world), [0.5, 0.5], [19.5, 19.5])
    }

    #[test]
    fn every_advice_is_taken_by_its_planner() {
        for advice in ADVICE {
            assert!(REGISTRY.iter().any(|entry| entry.name == advice.planner && entry.paper.is_some()));
            assert!(parameters(advice.planner, (advice.set)()).is_ok());
        }
    }

    #[test]
    fn the_map_decides_and_what_is_given_goes_first() {
        let of = |query: &Query, given| parameters_for("pso-aco", given, query).unwrap();
        assert_eq!(of(&query(2), json!({"preset": "recommended"}))["swarm_iterations"], 5);
        assert_eq!(of(&query(2), json!({"preset": "recommended", "swarm_iterations": 7}))["swarm_iterations"], 7);
        assert_eq!(of(&query(9), json!({"preset": "recommended"})), parameters("pso-aco", Value::Null).unwrap());
        assert_eq!(of(&query(2), Value::Null), parameters("pso-aco", Value::Null).unwrap());
    }

    #[test]
    fn the_preset_plans_as_its_parameters_do() {
        let query = query(2);
        let run = |set| {
            let mut ctx = Context::new(3).with_budget(Budget { evaluations: Some(500), ..Budget::default() }).unwrap();
            planner("pso-aco", set).unwrap().plan(&query, &mut ctx).unwrap()
        };
        let mut set = recommended("pso-aco", &query);
        set.insert("seeding".into(), json!("off"));
        let [preset, same, other] = [json!({"preset": "recommended", "seeding": "off"}), Value::Object(set), json!({"seeding": "off"})].map(run);
        assert_eq!((&preset.cells, &preset.history), (&same.cells, &same.history));
        assert_ne!(preset.history, other.history);
        assert!(planner("pso-aco", json!({"preset": "recommended", "ants": "many"})).is_err());
    }
}
