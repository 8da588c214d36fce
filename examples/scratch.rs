use rimbench::cosim::*;
use rimbench::harness::*;
use rimbench::*;
fn main() {
    let case = cases::case_by_name("wedge-box").unwrap();
    let solver = complementarity::solver_by_name("active-set").unwrap();
    // monolithic
    let mut fines: Vec<Trajectory> = vec![];
    for level in [1.0, 2.0, 4.0] {
        let h = 2.5e-5 / level;
        let steps = (2.5 / h as f64).round() as usize;
        let every = (5e-5 / h as f64).round() as usize;
        let mut sys = (case.build)(&case.default_parameters(), solver).unwrap();
        let mut rec = cases::Recorder::new(case, &sys);
        let mut tr = Trajectory::with_capacity(case.recorded_columns(), 50002);
        let t0 = std::time::Instant::now();
        mechanics::monolithic(&mut *sys.mechanics, &mut *sys.actuator, h, steps, every, &mut |p| {
            rec.record(p, &mut tr)
        })
        .unwrap();
        println!("mono h={h} {:?} rows {}", t0.elapsed(), tr.len());
        fines.push(tr);
    }
    let idx = |n: &str| fines[0].index_of(n).unwrap();
    let (f, gl, me, s) =
        (idx("actuator_force_n"), idx("gap_left_wedge_m"), idx("effective_mass_kg"), idx("actuator_length_m"));
    for c in [f, s] {
        let rms = |a: &Trajectory, b: &Trajectory| {
            (a.column(c).zip(b.column(c)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>() / a.len() as f64).sqrt()
        };
        println!("rms diffs col {c}: {} {}", rms(&fines[0], &fines[1]), rms(&fines[1], &fines[2]));
    }
    let r = &fines[2];
    for i in (0..r.len()).step_by(2500) {
        let row = r.row(i);
        println!(
            "{:.3} F={:.2} meff={:.3} gl={:.5} theta={:.5} x={:.4}",
            row[0], row[f], row[me], row[gl], row[3], row[1]
        );
    }
    let touch = r.rows().find(|row| row[gl] < 1e-7).unwrap()[0];
    println!("touch {touch}");
    println!("peak {} min {}", r.column(f).fold(-1e9, f64::max), r.column(f).fold(1e9, f64::min));
    for (scheme, h, fr, nm) in [
        ("zero-order-hold", 2e-4, None, 1),
        ("zero-order-hold", 5e-3, None, 1),
        ("first-order-hold", 5e-3, None, 1),
        ("second-order-hold", 5e-3, None, 1),
        ("rim-smooth", 5e-3, None, 1),
        ("rim-nonsmooth", 5e-3, None, 1),
        ("rim-nonsmooth-gap", 5e-3, None, 1),
        ("rim-nonsmooth-gap", 5e-3, Some(ForceReturn::Profile), 5),
        ("rim-nonsmooth-gap", 5e-3, Some(ForceReturn::Profile), 0),
        ("rim-nonsmooth-gap", 2e-2, Some(ForceReturn::Profile), 0),
        ("rim-nonsmooth", 5e-3, Some(ForceReturn::Profile), 0),
    ] {
        let e = schemes::scheme_by_name(scheme).unwrap();
        let (sequence, force_return) = e.sequence_and_return(None, fr).unwrap();
        let spec = RunSpec {
            case,
            parameters: case.default_parameters(),
            scheme: e,
            options: schemes::SchemeOptions {
                redundancy: interface_model::Redundancy::Drop,
                motion: schemes::ModelMotion::Frozen,
                solver,
            },
            macro_step: h,
            phase: 1.0,
            micro_step: 5e-5,
            mechanics_steps: nm,
            sequence,
            force_return,
            duration: 2.5,
            solver,
        };
        let res = simulate(&spec, Bounds { mechanics: vec![10.0, 1.0], actuator: vec![3000.0] }).unwrap();
        let t = &res.trajectory;
        let rms = (t.rows().map(|row| (row[f] - r.at(f, row[0])).powi(2)).sum::<f64>() / t.len() as f64).sqrt();
        let rms_s = (t.rows().map(|row| (row[s] - r.at(s, row[0])).powi(2)).sum::<f64>() / t.len() as f64).sqrt();
        let (mx, mn) = (t.column(f).fold(-1e9, f64::max), t.column(f).fold(1e9, f64::min));
        let lift = t.rows().filter(|r| r[0] > 0.0).map(|r| r[11]).fold(0.0, f64::max);
        println!(
            "{scheme} H={h} {fr:?} nm={nm}: {} rmsF={rms:.3} rms_s={rms_s:.3e} F[{mn:.1},{mx:.1}] lift={lift:.2e} wall={:?} lcp={:?} res={:?} ident={:?}",
            res.report.outcome,
            res.wall,
            res.scheme.solves,
            res.mechanics.solver.worst_residual,
            res.energy_identity_residual_j
        );
    }
}
