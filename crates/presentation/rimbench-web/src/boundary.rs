//! What a page calls: four functions and two places in memory.
//!
//! ```text
//! place = room(length)     write the request there, UTF-8
//! answer()                 simulates
//! words(), words_length()          the words of the answer, UTF-8
//! numbers(), numbers_length()      its numbers, f64 in the machine's order
//! ```
//! The places hold until the next call. The module imports nothing.

// A function that a page can call has a name that nothing else may have: that is all that is unsafe here.
#![allow(unsafe_code)]

use super::{Answer, Simulator};
use std::cell::RefCell;

#[derive(Default)]
struct State {
    simulator: Simulator,
    request: Vec<u8>,
    answer: Answer,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

fn with<T>(use_state: impl FnOnce(&mut State) -> T) -> T {
    STATE.with(|state| use_state(&mut state.borrow_mut()))
}

/// Makes room for a request of so many bytes, and returns where it is.
#[unsafe(no_mangle)]
pub extern "C" fn room(length: usize) -> *mut u8 {
    with(|state| {
        state.request.clear();
        state.request.resize(length, b' ');
        state.request.as_mut_ptr()
    })
}

/// Answers the request that was written; see [`Simulator::answer`].
#[unsafe(no_mangle)]
pub extern "C" fn answer() {
    with(|state| {
        let request = String::from_utf8_lossy(&state.request).into_owned();
        state.answer = state.simulator.answer(request.trim());
    });
}

/// Returns where the words of the last answer are.
#[unsafe(no_mangle)]
pub extern "C" fn words() -> *const u8 {
    with(|state| state.answer.words.as_ptr())
}

/// Returns how many bytes of words there are.
#[unsafe(no_mangle)]
pub extern "C" fn words_length() -> usize {
    with(|state| state.answer.words.len())
}

/// Returns where the numbers of the last answer are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    with(|state| state.answer.numbers.as_ptr())
}

/// Returns how many numbers there are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers_length() -> usize {
    with(|state| state.answer.numbers.len())
}
