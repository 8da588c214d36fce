//! A scheme whose code is not Rust: a class in a process of its own, or an object of another language in this one.
//!
//! ```text
//! Polynomial   once per macro step and side   u_i(t_k + τ) = Σ_p c_ip τ^p, p ≤ 3: input after input, its coefficients
//! Inputs       once per macro step and side   micro step after micro step, its inputs
//! Input        once per micro step and side   its inputs
//! ```

use super::input_polynomial::InputPolynomial;
use crate::cosim::{CouplingScheme, Cubic, MacroStep, MicroStep, PerSide, Ports, Sample, Side};
use crate::error::{Cause, Failure};

/// What a scheme from outside gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AnswerForm {
    /// Polynomials over a macro step, of which a side that does not integrate them takes the means.
    Polynomial,
    /// The inputs of all micro steps of a macro step.
    Inputs,
    /// The inputs of one micro step.
    Input,
}

impl AnswerForm {
    /// All of them, with the method that gives each, the one that is asked less often first.
    pub const METHODS: [(&'static str, AnswerForm); 3] =
        [("polynomial", AnswerForm::Polynomial), ("inputs", AnswerForm::Inputs), ("input", AnswerForm::Input)];
}

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub enum Asked<'a> {
    /// A macro step that a side is to cover in so many micro steps: polynomials or all inputs, as the form has it.
    MacroStep(MacroStep, usize),
    /// One micro step, with what the side puts out at its start.
    MicroStep(MicroStep, &'a [f64]),
}

/// Whoever answers.
pub trait Outside: Send {
    /// Takes note of what a side sends.
    ///
    /// # Errors
    /// What went wrong, in words.
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), String>;

    /// Replaces `told` by what side `to` gets; returns in how many rows that came, 0 of plain numbers.
    ///
    /// # Errors
    /// What went wrong, in words.
    fn answer(&mut self, to: Side, asked: Asked<'_>, told: &mut Vec<f64>) -> Result<usize, String>;

    /// Returns a copy in the present state, if there can be one.
    fn try_clone(&self) -> Option<Box<dyn Outside>>;
}

/// A scheme that asks whoever stands outside, and checks what it is told. One that could not be made fails when the run
/// begins, which is then a row with that reason.
pub struct OutsideScheme {
    who: Result<Box<dyn Outside>, String>,
    form: AnswerForm,
    /// The macro step of the newest sample.
    step: MacroStep,
    /// Polynomials, and numbers as they were told, for each side that takes them.
    polynomials: PerSide<InputPolynomial>,
    told: PerSide<Vec<f64>>,
}

fn failed(message: String) -> Failure {
    Cause::SchemeReported { message }.into()
}

impl OutsideScheme {
    /// Lets `who` answer for the sides with these ports.
    pub fn new(who: Result<Box<dyn Outside>, String>, form: AnswerForm, ports: PerSide<&Ports>) -> Self {
        let polynomials = ports.map(|ports| InputPolynomial::new(ports.inputs.len(), 0));
        let step = MacroStep { index: 0, start: 0.0, length: 0.0 };
        OutsideScheme { who, form, step, polynomials, told: PerSide::default() }
    }

    fn who(&mut self) -> Result<&mut Box<dyn Outside>, Failure> {
        self.who.as_mut().map_err(|message| failed(message.clone()))
    }

    /// Asks for `rows` of numbers, each of one of `widths`, and returns how many numbers a row has.
    fn ask(&mut self, to: Side, asked: Asked<'_>, rows: usize, widths: [usize; 2]) -> Result<usize, Failure> {
        let mut told = std::mem::take(&mut self.told[to]);
        let answered = self.who().and_then(|who| who.answer(to, asked, &mut told).map_err(failed));
        let (in_rows, count) = (answered?, told.len());
        let unknown = told.iter().copied().find(|number| !number.is_finite());
        self.told[to] = told;
        let wanted = || {
            let [least, most] = widths;
            let each = if least == most { format!("{most}") } else { format!("{least} to {most}") };
            format!("valid: {rows} rows of {each}")
        };
        match unknown {
            Some(number) => Err(self.wrong(to, format!("{number}; valid: finite numbers"))),
            None if in_rows != 0 && in_rows != rows => Err(self.wrong(to, format!("{in_rows} rows; {}", wanted()))),
            None if count % rows == 0 && (widths[0]..=widths[1]).contains(&(count / rows)) => Ok(count / rows),
            None => Err(self.wrong(to, format!("{count} numbers; {}", wanted()))),
        }
    }

    #[cold]
    fn wrong(&self, to: Side, what: String) -> Failure {
        let method = AnswerForm::METHODS[self.form as usize].0;
        let side = if to == Side::Mechanics { "mechanics" } else { "actuator" };
        failed(format!("{method} of the {side} at {} s gives {what}", self.step.start))
    }
}

impl CouplingScheme for OutsideScheme {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.step = sample.step;
        self.who()?.receive(from, sample).map_err(failed)
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let n = u.len();
        if n == 0 {
            return Ok(());
        }
        let step = Asked::MacroStep(self.step, at.count);
        match self.form {
            AnswerForm::Input => {
                self.ask(to, Asked::MicroStep(at, own), 1, [n, n])?;
                u.copy_from_slice(&self.told[to]);
                return Ok(());
            }
            AnswerForm::Polynomial if at.index == 0 => {
                let each = self.ask(to, step, n, [1, 4])?;
                let told = &self.told[to];
                let row = |i: usize| std::array::from_fn(|p| if p < each { told[i * each + p] } else { 0.0 });
                self.polynomials[to].set(each - 1, (0..n).map(row));
            }
            AnswerForm::Inputs if at.index == 0 => {
                self.ask(to, step, at.count, [n, n])?;
            }
            _ => {}
        }
        match self.form {
            AnswerForm::Polynomial => self.polynomials[to].mean(at, u),
            _ => u.copy_from_slice(&self.told[to][at.index * n..][..n]),
        }
        Ok(())
    }

    fn input_polynomials(&self, to: Side, at: MicroStep, polynomials: &mut [Cubic]) -> bool {
        self.form == AnswerForm::Polynomial && self.polynomials[to].within(at, polynomials)
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        let who = Ok(self.who.as_ref().ok()?.try_clone()?);
        let (polynomials, told) = (self.polynomials.clone(), self.told.clone());
        Some(Box::new(OutsideScheme { who, form: self.form, step: self.step, polynomials, told }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{Port, Quantity};
    use std::sync::{Arc, Mutex};

    /// Gives 3 for everything, and notes how many numbers.
    struct Three(Arc<Mutex<Vec<usize>>>);

    impl Outside for Three {
        fn receive(&mut self, _: Side, _: &Sample<'_>) -> Result<(), String> {
            Ok(())
        }

        fn answer(&mut self, _: Side, asked: Asked<'_>, told: &mut Vec<f64>) -> Result<usize, String> {
            *told = vec![3.0; if let Asked::MacroStep(_, count) = asked { count } else { 1 }];
            self.0.lock().unwrap().push(told.len());
            Ok(0)
        }

        fn try_clone(&self) -> Option<Box<dyn Outside>> {
            None
        }
    }

    #[test]
    fn it_is_asked_once_in_a_macro_step_for_all_of_it_or_in_each_micro_step() {
        let force = Ports { inputs: vec![Port::new("f", Quantity::Force)], outputs: vec![], direct_feedthrough: false };
        let step = MacroStep { index: 0, start: 0.0, length: 1.0 };
        for (_, form) in AnswerForm::METHODS {
            let asked = Arc::new(Mutex::new(Vec::new()));
            let who = Ok(Box::new(Three(asked.clone())) as Box<dyn Outside>);
            let mut scheme = OutsideScheme::new(who, form, PerSide { mechanics: &force, actuator: &force });
            for index in 0..4 {
                let mut u = [0.0];
                scheme.input(Side::Mechanics, MicroStep::new(step, index, 4), &[], &mut u).unwrap();
                // Of the polynomial 3 (1 + τ + τ² + τ³) the mean over the micro step.
                let to = |t: f64| 3.0 * (t + t.powi(2) / 2.0 + t.powi(3) / 3.0 + t.powi(4) / 4.0);
                let mean = 4.0 * (to(0.25 * (index + 1) as f64) - to(0.25 * index as f64));
                let wanted = if form == AnswerForm::Polynomial { mean } else { 3.0 };
                approx::assert_relative_eq!(u[0], wanted, max_relative = 1e-14);
            }
            let wanted = if form == AnswerForm::Input { vec![1; 4] } else { vec![4] };
            assert_eq!(*asked.lock().unwrap(), wanted, "{form:?}");
        }
    }
}
