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

    /// Replaces `told` by what side `to` gets.
    ///
    /// # Errors
    /// What went wrong, in words.
    fn answer(&mut self, to: Side, asked: Asked<'_>, told: &mut Vec<f64>) -> Result<(), String>;

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

    /// Asks, and checks that all is finite.
    fn ask(&mut self, to: Side, asked: Asked<'_>) -> Result<(), Failure> {
        let mut told = std::mem::take(&mut self.told[to]);
        let answered = self.who().and_then(|who| who.answer(to, asked, &mut told).map_err(failed));
        self.told[to] = told;
        answered?;
        match self.told[to].iter().find(|number| !number.is_finite()) {
            Some(number) => Err(self.wrong(to, format!("{number}; valid: finite numbers"))),
            None => Ok(()),
        }
    }

    #[cold]
    fn wrong(&self, to: Side, what: String) -> Failure {
        let method = AnswerForm::METHODS[self.form as usize].0;
        let side = if to == Side::Mechanics { "mechanics" } else { "actuator" };
        failed(format!("{method} of the {side} at {} s gives {what}", self.step.start))
    }

    fn check_count(&self, to: Side, wanted: usize, of: &str) -> Result<(), Failure> {
        let count = self.told[to].len();
        if count == wanted { Ok(()) } else { Err(self.wrong(to, format!("{count} numbers instead of {wanted}, {of}"))) }
    }
}

impl CouplingScheme for OutsideScheme {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        self.step = sample.step;
        self.who()?.receive(from, sample).map_err(failed)
    }

    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let n = u.len();
        if self.form == AnswerForm::Input {
            self.ask(to, Asked::MicroStep(at, own))?;
            self.check_count(to, n, "one for each input")?;
            u.copy_from_slice(&self.told[to]);
            return Ok(());
        }
        if at.index == 0 {
            self.ask(to, Asked::MacroStep(self.step, at.count))?;
            if self.form == AnswerForm::Polynomial {
                let each = self.told[to].len() / n.max(1);
                self.check_count(to, n * each.clamp(1, 4), "one to four coefficients for each input")?;
                let told = &self.told[to];
                let row = |i: usize| std::array::from_fn(|p| if p < each { told[i * each + p] } else { 0.0 });
                self.polynomials[to].set(each - 1, (0..n).map(row));
            } else {
                self.check_count(to, n * at.count, "one for each micro step and input")?;
            }
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
