//! The reference run against an implementation that shares no code with it.

use crate::support::*;
use rimbench_independent::plain_wedge_box::{EFFECTIVE_MASS, Effort, PlainWedgeBox, RANK, Row};

#[test]
fn the_reference_run_follows_the_plain_implementation_to_round_off() {
    let options = [("macro_step_s", "2e-4"), ("micro_step_s", "5e-5"), ("duration_s", "2.5")];
    let ours = run(&spec_with("wedge-box", "zero-order-hold", &options, &[])).trajectory;
    let plain = PlainWedgeBox::new(Effort::Same).run(2e-4, 4, 12_500);
    assert_eq!(ours.len(), plain.len());
    let check = |name: &str, of_ours: fn(f64) -> f64, of_plain: &dyn Fn(&Row) -> f64| {
        let column = ours.index_of(name).unwrap();
        let largest = plain.iter().map(|row| of_plain(row).abs()).fold(0.0, f64::max);
        let worst = ours.column(column).zip(&plain).map(|(value, row)| (of_ours(value) - of_plain(row)).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst <= 1e-8 * largest, "{name}: {worst:.1e} apart, largest {largest:.1e}");
    };
    check("actuator_length_m", |x| x, &|row| row.interface[0]);
    check("actuator_velocity_m_s", |x| x, &|row| row.interface[1]);
    check("actuator_force_n", |x| x, &|row| row.interface[2]);
    check("rank_h_uu", |x| x, &|row| row.observed[RANK]);
    // Its inverse, because the mass itself is infinite, or round-off of it, where the box is locked.
    check("effective_mass_kg", |mass| 1.0 / mass, &|row| 1.0 / row.observed[EFFECTIVE_MASS]);
}
