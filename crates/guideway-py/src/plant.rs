//! A Python object as a plant.

use crate::errors::to_py;
use guideway::drive::{Command, Motion, Observation, Plant};
use guideway::error::PlanError;
use pyo3::prelude::*;

/// A Python object with `observe()`, `step(v, w, dt)` and `motion()`. What it raises ends the run and is kept; from then on it stands where it was last.
pub struct Called {
    object: Py<PyAny>,
    seen: Observation,
    motion: Motion,
    raised: Option<PyErr>,
}

impl Called {
    /// Looks at the object once.
    /// # Errors
    /// What the object raises, and `BadParameter` for what is no plant.
    pub fn new(object: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = object.py();
        for name in ["observe", "step", "motion"] {
            if !object.getattr(name).is_ok_and(|method| method.is_callable()) {
                let allowed = "an object with observe(), step(v, w, dt) and motion()";
                return Err(to_py(py, &PlanError::bad("plant", format!("{} without {name}()", object.get_type()), allowed)));
            }
        }
        let motion = state("motion", &object.call_method0("motion")?)?;
        let seen = Observation::new(0.0, motion.pose, motion.v, motion.w);
        Ok(Self { object: object.clone().unbind(), seen, motion, raised: None })
    }

    /// What the object raised.
    pub fn raised(self) -> Option<PyErr> {
        self.raised
    }

    /// Calls the object unless it has failed; keeps what it raises.
    fn call<T>(&mut self, work: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>) -> Option<T> {
        if self.raised.is_some() {
            return None;
        }
        let result = Python::attach(|py| work(self.object.bind(py)));
        result.map_err(|error| self.raised = Some(error)).ok()
    }
}

impl Plant for Called {
    fn observe(&mut self) -> Observation {
        let seen = self.call(|object| {
            let answer = object.call_method0("observe")?;
            let Motion { pose, v, w } = state("observe", &answer)?;
            Ok(Observation::new(number("observe", "time", &answer)?, pose, v, w))
        });
        if let Some(seen) = seen {
            self.seen = seen;
        }
        self.seen.clone()
    }

    fn step(&mut self, u: Command, dt: f64) {
        let motion = self.call(|object| {
            object.call_method1("step", (u.v, u.w, dt))?;
            state("motion", &object.call_method0("motion")?)
        });
        self.motion = motion.unwrap_or(self.motion);
    }

    fn motion(&self) -> Motion {
        self.motion
    }

    fn failed(&self) -> bool {
        self.raised.is_some()
    }
}

/// Pose and speeds from an answer `{"pose": (x, y, yaw), "v": v, "w": w}`.
fn state(method: &str, answer: &Bound<'_, PyAny>) -> PyResult<Motion> {
    let pose = answer.get_item("pose")?.try_iter()?.map(|value| value?.extract()).collect::<PyResult<Vec<f64>>>()?;
    let bad =
        |shown: String| to_py(answer.py(), &PlanError::bad(format!("plant.{method}().pose"), shown, "three finite numbers: x, y in m, yaw in rad"));
    let pose: [f64; 3] = pose.clone().try_into().map_err(|_| bad(format!("{pose:?}")))?;
    if !pose.iter().all(|value| value.is_finite()) {
        return Err(bad(format!("{pose:?}")));
    }
    Ok(Motion { pose, v: number(method, "v", answer)?, w: number(method, "w", answer)? })
}

fn number(method: &str, key: &str, answer: &Bound<'_, PyAny>) -> PyResult<f64> {
    let value: f64 = answer.get_item(key)?.extract()?;
    if value.is_finite() {
        return Ok(value);
    }
    Err(to_py(answer.py(), &PlanError::bad(format!("plant.{method}().{key}"), value, "a finite number")))
}
