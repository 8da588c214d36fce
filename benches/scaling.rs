//! Cost of a macro step against the number of contacts and bodies: building the interface model, using it, and the
//! mechanics' own step, each by itself.
//!
//! Families, in the state that costs most, all supports or discs in contact:
//!
//! - `n-wedge-box` after its manoeuvre: two bodies on 2 to 64 coplanar wedges (rank 2 of H_uu), the disc in the air;
//! - `wedge-box-space` after its manoeuvre: four wedges and a ball in space, with friction, three of six contacts
//!   closed;
//! - `disc-row` pushed against the wall: n + 1 bodies, 2n + 1 contacts, all of them needed;
//! - `disc-pile` against the wall: a heap whose contacts are redundant;
//! - `packed-box` with its wall let out: n discs in layers, 2n of the contacts closed, all of them needed.
//!
//! With n velocities, n_b joint rows and n_u contacts the elimination is `n_u² n` products at most (less by what is
//! zero), the model's copy and packing `n_u²`, a micro step of the model `2 n_u²` with a warm active set plus what its
//! right-hand side changes in it. Exponents are slopes of least squares in logarithms, over the systems with 64
//! contacts or more.
//!
//! Settled, that is the state at the end, again and again; in motion, every macro step on the way there is made once
//! more from its start, with the set of the one before, so that all changes of the set are in it (each macro step the
//! shortest of three passes).
//!
//! Nothing is timed before it is verified: the model, used with one micro step of H, must give the velocity that the
//! mechanics itself reaches; the contact forces must carry the weight and, in the row, hand the push on to the wall.
//! Without `--bench` only that is done, on the small systems. `--case NAME` leaves the other families out, `--bodies N`
//! the systems with more (the largest heap takes half an hour), but not out of what `--csv` prints.

use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Bounds, CouplingScheme, MacroStep, MicroStep, Outcome, RunControl, Sample, Side, Subsystem};
use rimbench::interface_model::ReducedInterfaceModel;
use rimbench::runs::RunRequest;
use rimbench::statistics::{Pool, order_of_convergence};
use std::hint::black_box;
use std::time::{Duration, Instant};

const SCHEME: &str = "rim-nonsmooth-gap";
const H: f64 = 5e-3;
const MICRO_STEPS: usize = 100;
const GRAVITY: f64 = 9.81;
/// Contacts from which an exponent is fitted.
const LARGE: usize = 64;
/// Time for each measurement, and least and greatest number of repetitions.
const BUDGET: Duration = Duration::from_millis(300);
const REPETITIONS: [usize; 2] = [5, 20_000];
/// Passes over a motion, of which each macro step keeps its shortest times.
const PASSES: usize = 3;
/// Of the forces: contacts hold to the solver's tolerance, and what moves at the end of the manoeuvre decays.
const FORCE_TOLERANCE: f64 = 1e-6;

/// A system of a family.
struct Size {
    set: Vec<(&'static str, usize)>,
    bodies: usize,
    /// Sum of the contact forces, N, for a force of the actuator, where statics tells.
    contact_force: Option<Box<dyn Fn(f64) -> f64>>,
}

/// A case at several sizes, run until `settled_s`.
struct Family {
    case: &'static str,
    set: &'static [(&'static str, &'static str)],
    settled_s: f64,
    sizes: Vec<Size>,
}

fn families(whole: bool) -> [Family; 5] {
    let up_to = |sizes: &[usize]| sizes[..if whole { sizes.len() } else { 2 }].to_vec();
    let box_of = |supports| Size {
        set: vec![("supports", supports)],
        bodies: 2,
        contact_force: Some(Box::new(|_| 250.0 * GRAVITY)),
    };
    let row_of = |discs: usize| {
        let count = discs as f64;
        // Each disc stands on the floor; the push goes through the blade's contact, those between discs and the wall's.
        let force = move |push: f64| 20.0 * GRAVITY * count + push * (count + 1.0);
        Size { set: vec![("discs", discs)], bodies: discs + 1, contact_force: Some(Box::new(force)) }
    };
    let pile_of = |columns: usize, layers: usize| {
        let discs = columns * layers - layers / 2;
        // Lighter ones where there are many, or the cylinder cannot hold them.
        let mass = (4000 / discs).min(20);
        Size {
            set: vec![("columns", columns), ("layers", layers), ("disc_mass_kg", mass)],
            bodies: 1 + discs,
            contact_force: None,
        }
    };
    // Lighter discs in the larger ones, or the cylinder cannot hold the wall.
    let packing_of = |columns: usize, layers: usize, mass| Size {
        set: vec![("columns", columns), ("layers", layers), ("disc_mass_kg", mass)],
        bodies: 1 + columns * layers - layers / 2,
        contact_force: None,
    };
    let packings = [(4, 5, 20), (6, 7, 20), (10, 10, 20), (20, 20, 8), (40, 30, 4), (60, 40, 2)];
    let piles = [(2, 2), (4, 3), (6, 4), (8, 6), (10, 8), (15, 12), (22, 18), (32, 26), (46, 38)];
    [
        Family {
            case: "n-wedge-box",
            set: &[],
            settled_s: 2.5,
            sizes: up_to(&[2, 4, 8, 16, 32, 64]).into_iter().map(box_of).collect(),
        },
        Family {
            case: "wedge-box-space",
            set: &[],
            settled_s: 2.5,
            sizes: vec![Size { set: vec![("box_mass_kg", 200)], bodies: 2, contact_force: None }],
        },
        Family {
            case: "disc-row",
            set: &[("disc_gap_m", "0"), ("wall_gap_m", "0")],
            settled_s: 0.25,
            sizes: up_to(&[2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2500]).into_iter().map(row_of).collect(),
        },
        Family {
            case: "disc-pile",
            set: &[("wall_gap_m", "0")],
            settled_s: 0.25,
            sizes: piles[..if whole { piles.len() } else { 2 }].iter().map(|&(c, l)| pile_of(c, l)).collect(),
        },
        Family {
            case: "packed-box",
            set: &[],
            settled_s: 0.35,
            sizes: packings[..if whole { packings.len() } else { 2 }]
                .iter()
                .map(|&(c, l, m)| packing_of(c, l, m))
                .collect(),
        },
    ]
}

/// A run stopped at a communication point: both samples and the mechanics in that state.
struct Stopped {
    /// Both as they are at the start, and the mechanics as it is now.
    start: Box<dyn Subsystem>,
    mechanics: Box<dyn Subsystem>,
    scheme: Box<dyn CouplingScheme>,
    /// Outputs of both sides at all communication points.
    points: Vec<[Vec<f64>; 2]>,
    model: ReducedInterfaceModel,
    motion: Vec<f64>,
    force: Vec<f64>,
    step: MacroStep,
}

impl Stopped {
    fn new(family: &Family, size: &Size) -> Self {
        let fixed = family.set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned()));
        let of_size = size.set.iter().map(|(key, value)| ((*key).to_owned(), value.to_string()));
        let request = RunRequest {
            set: fixed.chain(of_size).collect(),
            macro_step_s: Some(H),
            micro_step_s: Some(H / MICRO_STEPS as f64),
            duration_s: Some(family.settled_s),
            ..RunRequest::of(family.case, SCHEME)
        };
        let spec = request.resolve(&Catalogue::standard()).unwrap();
        let mut system = (spec.case.build)(&spec.parameters, &spec.solver).unwrap();
        let setup = spec.setup(Bounds::default());
        let coupling = spec.scheme.couple(system.sides.lend(), spec.model.as_ref(), spec.gain).unwrap();
        let scheme = coupling.scheme.try_clone().unwrap();
        let start = system.sides.mechanics.try_clone().unwrap();
        let mut points = Vec::new();
        let report = coupling.run(&setup, system.sides.lend(), RunControl::default(), &mut |point| {
            points.push([point.y.mechanics.to_vec(), point.y.actuator.to_vec()]);
        });
        assert_eq!(report.outcome, Outcome::Completed, "{} {:?}", family.case, size.set);
        let mut mechanics = system.sides.mechanics;
        let mut model = mechanics.capabilities().empty_interface_model().unwrap();
        assert!(mechanics.capabilities().interface_model(H, &mut model).unwrap());
        let step = setup.grid.step(0);
        let [motion, force] = points.last().unwrap().clone();
        Stopped { start, mechanics, scheme, points, model, motion, force, step }
    }

    /// The same system at its start.
    fn at_start(&self) -> Self {
        Stopped {
            start: self.start.try_clone().unwrap(),
            mechanics: self.start.try_clone().unwrap(),
            scheme: self.scheme.try_clone().unwrap(),
            points: Vec::new(),
            model: self.model.clone(),
            motion: self.motion.clone(),
            force: self.force.clone(),
            step: self.step,
        }
    }

    /// The scheme takes the model, for micro steps of `H / count`.
    fn receive(&mut self, count: usize) {
        let sample =
            Sample { model: Some(&self.model), ..Sample::of_outputs(self.step, &self.motion, H / count as f64) };
        self.scheme.receive(Side::Mechanics, &sample).unwrap();
        self.scheme.receive(Side::Actuator, &Sample { y: &self.force, model: None, ..sample }).unwrap();
    }

    /// The inputs of a macro step with the actuator's force held; returns the last.
    fn inputs(&mut self, count: usize) -> [f64; 2] {
        let mut u = [self.motion[0], self.motion[1]];
        for index in 0..count {
            let at = MicroStep::new(self.step, index, count);
            self.scheme.input(Side::Actuator, at, black_box(&self.force), &mut u).unwrap();
        }
        u
    }

    /// Contacts closed, and the sum of contact forces in the last step.
    fn observed(mechanics: &mut dyn Subsystem) -> [f64; 3] {
        let names = mechanics.capabilities().observables().to_vec();
        let mut row = vec![0.0; names.len()];
        mechanics.capabilities().observe(H, &mut row);
        ["closed_contacts", "rank_h_uu", "contact_force_sum_n"]
            .map(|name| row[names.iter().position(|known| *known == name).unwrap()])
    }

    /// Checks the answers; returns closed contacts and their rank.
    fn verify(&mut self, size: &Size) -> [f64; 2] {
        let mut after = self.mechanics.try_clone().unwrap();
        after.step(0.0, &self.force, H).unwrap();
        let mut motion = vec![0.0; self.motion.len()];
        after.outputs(&self.force, &mut motion).unwrap();
        self.receive(1);
        let used = self.inputs(1);
        // The actuator alone would change the velocity by this much.
        let first = self.model.interface_start();
        let free = H * self.model.entry(first, first) * self.force[0].abs();
        // What still slides in space turns its row by up to H w / length in the step, which the frozen model does not.
        let turned = if self.model.is_in_space() { H * motion[1].powi(2) / motion[0] } else { 0.0 };
        let tolerance = FORCE_TOLERANCE * (free + motion[1].abs()) + turned;
        assert!((used[1] - motion[1]).abs() <= tolerance, "{used:?} instead of {motion:?} m, m/s");

        let [_, _, carried] = Self::observed(&mut *after);
        if let Some(statics) = &size.contact_force {
            let expected = statics(self.force[0]);
            let apart = (carried - expected).abs();
            assert!(apart <= FORCE_TOLERANCE * expected, "contacts carry {carried} N instead of {expected} N");
        }
        let [closed, rank, _] = Self::observed(&mut *self.mechanics);
        [closed, rank]
    }

    /// Pivots, factorisations and fallbacks to another solver per micro step.
    fn work(&mut self) -> [f64; 3] {
        self.receive(MICRO_STEPS);
        self.inputs(MICRO_STEPS);
        let before = self.scheme.report().counters;
        self.receive(MICRO_STEPS);
        self.inputs(MICRO_STEPS);
        let spent = self.scheme.report().counters.since(&before);
        [spent.pivots, spent.factorisations, spent.fallbacks].map(|count| count as f64 / MICRO_STEPS as f64)
    }

    /// Times, s: building the model, taking it, using it for a macro step, the mechanics' step; of each what `usual`
    /// makes of many.
    fn measure(&mut self, usual: fn(Vec<f64>) -> f64) -> Times {
        // The reduction is kept for the step it was made for; a step of another length asks for a new one.
        let mut model = self.model.clone();
        let mut length = H;
        let build = repeated(usual, || {
            length = if length == H { 0.5 * H } else { H };
            timed(|| self.mechanics.capabilities().interface_model(black_box(length), &mut model).unwrap())
        });
        let take = repeated(usual, || timed(|| self.receive(MICRO_STEPS)));
        let using = repeated(usual, || {
            self.receive(MICRO_STEPS);
            timed(|| self.inputs(MICRO_STEPS))
        });
        let mut copy = self.mechanics.try_clone().unwrap();
        let mut steps = 0;
        let step = repeated(usual, || {
            if steps % 20 == 0 {
                copy = self.mechanics.try_clone().unwrap();
            }
            steps += 1;
            copy.capabilities().interface_model(H, &mut model).unwrap();
            timed(|| copy.step(0.0, black_box(&self.force), H).unwrap())
        });
        [build, take, using, step]
    }
}

/// Times of building, taking, using and stepping.
type Times = [f64; 4];

/// The same for every macro step of the motion, s, with the actuator's force held over each.
fn measure_motion(stopped: &Stopped) -> Vec<Times> {
    let mut shortest = Vec::new();
    for _ in 0..PASSES {
        let (mut mechanics, scheme) = (stopped.start.try_clone().unwrap(), stopped.scheme.try_clone().unwrap());
        let mut at = Stopped { scheme, ..stopped.at_start() };
        for (index, [motion, force]) in stopped.points[..stopped.points.len() - 1].iter().enumerate() {
            at.motion.clone_from(motion);
            at.force.clone_from(force);
            let build = timed(|| mechanics.capabilities().interface_model(H, &mut at.model).unwrap());
            let take = timed(|| at.receive(MICRO_STEPS));
            let using = timed(|| at.inputs(MICRO_STEPS));
            let step = timed(|| mechanics.step(0.0, force, H).unwrap());
            let times = [build, take, using, step];
            match shortest.get_mut(index) {
                None => shortest.push(times),
                Some(kept) => {
                    kept.iter_mut().zip(times).for_each(|(kept, time): (&mut f64, f64)| *kept = kept.min(time))
                }
            }
        }
    }
    shortest
}

fn timed<T>(task: impl FnOnce() -> T) -> f64 {
    let started = Instant::now();
    black_box(task());
    started.elapsed().as_secs_f64()
}

fn middle(times: Vec<f64>) -> f64 {
    Pool::of(times).median().expect("times")
}

fn shortest(times: Vec<f64>) -> f64 {
    times.into_iter().fold(f64::INFINITY, f64::min)
}

fn repeated(usual: fn(Vec<f64>) -> f64, mut once: impl FnMut() -> f64) -> f64 {
    let (started, [least, most]) = (Instant::now(), REPETITIONS);
    let mut times = Vec::new();
    while times.len() < least || (started.elapsed() < BUDGET && times.len() < most) {
        times.push(once());
    }
    usual(times)
}

/// Largest system of [`print_csv`].
const LARGEST_COMPARED: usize = 5100;

/// Prints systems, answers and times as CSV, for a comparison with others (`benches/peers`): settled, the shortest of
/// many; moving, the median over the macro steps, each the shortest of its passes.
fn print_csv(only: Option<&str>) {
    println!("case,parameters,state,contacts,closed,push_n,contact_force_n,build_us,take_us,use_us,step_us");
    // The other engines have no packings.
    let compared = |family: &Family| family.case != "packed-box" && only.is_none_or(|case| case == family.case);
    for family in families(true).into_iter().filter(compared) {
        for size in &family.sizes {
            let mut stopped = Stopped::new(&family, size);
            let contacts = stopped.model.contacts();
            if contacts > LARGEST_COMPARED {
                break;
            }
            let [closed, _] = stopped.verify(size);
            let mut after = stopped.mechanics.try_clone().unwrap();
            after.step(0.0, &stopped.force, H).unwrap();
            let [_, _, carried] = Stopped::observed(&mut *after);
            let parameters: Vec<String> = size.set.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let (case, parameters, push) = (family.case, parameters.join(";"), stopped.force[0]);
            let motion = measure_motion(&stopped);
            let moving = [0, 1, 2, 3].map(|part| middle(motion.iter().map(|times| times[part]).collect()));
            for (state, times) in [("settled", stopped.measure(shortest)), ("moving", moving)] {
                let [build, take, using, step] = times.map(|time| 1e6 * time);
                println!(
                    "{case},{parameters},{state},{contacts},{closed},{push},{carried},{build:.3},{take:.3},{using:.3},{step:.3}"
                );
            }
        }
    }
}

fn main() {
    let asked = |name: &str| std::env::args().any(|argument| argument == name);
    let after = |name: &str| std::env::args().skip_while(|argument| argument != name).nth(1);
    let whole = asked("--bench");
    if asked("--csv") {
        return print_csv(after("--case").as_deref());
    }
    println!(
        "One macro step of {SCHEME} at H = 5 ms, ns: building the model, taking it, {MICRO_STEPS} micro steps with it,"
    );
    println!("and the mechanics' own step (its reduction is the model's); the share of the real-time budget H.");
    let only = after("--case");
    let number = |text: Option<String>| text.and_then(|text| text.parse().ok()).expect("a number after --bodies");
    let most = if asked("--bodies") { number(after("--bodies")) } else { usize::MAX };
    for family in families(whole).into_iter().filter(|family| only.as_deref().is_none_or(|case| case == family.case)) {
        println!("\n{} {:?}", family.case, family.set);
        println!(
            "  bodies contacts closed rank      build       take        use       step  share of H  pivots factorisations fallbacks per micro step"
        );
        let [mut points, mut moving]: [[Vec<(f64, f64)>; 4]; 2] = Default::default();
        for size in family.sizes.iter().filter(|size| size.bodies <= most) {
            let mut stopped = Stopped::new(&family, size);
            let motion = if whole { measure_motion(&stopped) } else { Vec::new() };
            let [closed, rank] = stopped.verify(size);
            let contacts = stopped.model.contacts();
            print!("  {:6} {contacts:8} {closed:6} {rank:4}", size.bodies);
            if !whole {
                println!(" verified");
                continue;
            }
            let times = stopped.measure(middle);
            times.iter().for_each(|time| print!(" {:10.0}", 1e9 * time));
            let [pivots, factorisations, fallbacks] = stopped.work();
            print!(" {:9.3} %", 100.0 * times.iter().sum::<f64>() / H);
            println!(" {pivots:7.2} {factorisations:14.2} {fallbacks:9.2}");
            let medians = [0, 1, 2, 3].map(|part| middle(motion.iter().map(|times| times[part]).collect()));
            let mut shares: Vec<f64> = motion.iter().map(|times| 100.0 * times.iter().sum::<f64>() / H).collect();
            shares.sort_by(f64::total_cmp);
            print!("  {:>27}", "in motion");
            medians.iter().for_each(|time| print!(" {:10.0}", 1e9 * time));
            println!(" {:9.3} %, at most {:.3} %", shares[shares.len() / 2], shares[shares.len() - 1]);
            if contacts >= LARGE {
                let size = contacts as f64;
                points.iter_mut().zip(times).for_each(|(points, time)| points.push((size, time)));
                moving.iter_mut().zip(medians).for_each(|(points, time)| points.push((size, time)));
            }
        }
        if whole {
            for (name, points) in [("settled", points), ("in motion", moving)] {
                print!("  exponent in contacts, from {LARGE} on, {name}:");
                // One system alone has no exponent.
                let exponents = points.iter().map(|points| order_of_convergence(points).unwrap_or(f64::NAN));
                exponents.for_each(|exponent| print!(" {exponent:9.2} "));
                println!();
            }
        }
    }
}
