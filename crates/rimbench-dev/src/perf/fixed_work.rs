//! A piece of work that never changes: what times of different sessions on one machine are divided by.

use std::hint::black_box;

/// Rounds; a few milliseconds on a core of 2020.
const ROUNDS: u32 = 1 << 20;

/// Does a fixed amount of dependent floating-point and integer work.
///
/// Changing this function makes every recorded time ratio worthless: begin a new history then.
pub fn fixed_work() -> f64 {
    let (mut state, mut sum, mut table) = (black_box(0x9E37_79B9_7F4A_7C15_u64), black_box(0.5_f64), [0.5_f64; 64]);
    for _ in 0..ROUNDS {
        // xorshift64
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let slot = (state & 63) as usize;
        sum = 0.75 * sum + 0.25 * table[slot];
        table[slot] = if state & 64 == 0 { sum + 0.125 } else { 0.875 * sum };
    }
    black_box(sum)
}
