//! Lets a scheme answer the line protocol.

use serde_json::{Value, json};
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};

/// A side of the coupling.
#[derive(Clone, Copy, PartialEq)]
pub enum Side {
    Mechanics,
    Actuator,
}

impl Side {
    const BOTH: [(&str, Side); 2] = [("mechanics", Side::Mechanics), ("actuator", Side::Actuator)];

    /// The one that gives this one its inputs.
    pub fn other(self) -> Side {
        if self == Side::Mechanics { Side::Actuator } else { Side::Mechanics }
    }
}

/// What a side has said of its outputs at a communication point.
pub struct Sample {
    /// When, s.
    pub time: f64,
    /// The outputs, in the order of its ports.
    pub y: Vec<f64>,
}

/// An input over the macro step: coefficients of a polynomial in the time since its beginning, the constant first.
pub type Input = Vec<f64>;

/// What a scheme does.
pub trait Scheme {
    /// Takes note of a sample; each comes once.
    fn receive(&mut self, side: Side, sample: &Sample);
    /// Says what a side gets in the macro step that follows.
    fn inputs(&mut self, side: Side) -> Vec<Input>;
}

/// Answers until the other end has no more questions; each run begins with a scheme of its own.
pub fn serve<S: Scheme>(begin: impl Fn() -> S) -> Result<(), Box<dyn Error>> {
    let mut scheme = begin();
    let mut received = [None; 2];
    let mut out = stdout().lock();
    for line in stdin().lock().lines() {
        let asked: Value = serde_json::from_str(&line?)?;
        let mut reply = match asked["ask"].as_str() {
            Some("hello") => json!({ "protocol": "rimbench-line", "version": 1, "role": "scheme" }),
            Some("begin") => {
                (scheme, received) = (begin(), [None; 2]);
                json!({})
            }
            Some("inputs") => {
                for (name, side) in Side::BOTH {
                    let sample = sample(&asked[name])?;
                    // Where the mechanics goes first, its sample of the end comes again with the next step.
                    if received[side as usize].replace(sample.time) != Some(sample.time) {
                        scheme.receive(side, &sample);
                    }
                }
                let inputs =
                    Side::BOTH.map(|(name, side)| (name.to_owned(), json!({ "polynomials": scheme.inputs(side) })));
                Value::Object(inputs.into_iter().collect())
            }
            _ => json!({}),
        };
        reply["id"] = asked["id"].clone();
        writeln!(out, "{reply}")?;
        out.flush()?;
    }
    Ok(())
}

fn sample(said: &Value) -> Result<Sample, Box<dyn Error>> {
    let time = said["time_s"].as_f64().ok_or("a sample without time_s")?;
    let y: Option<Vec<f64>> = said["y"].as_array().into_iter().flatten().map(Value::as_f64).collect();
    Ok(Sample { time, y: y.ok_or("a sample that is no numbers")? })
}
