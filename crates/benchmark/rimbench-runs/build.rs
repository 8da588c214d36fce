//! Bakes in a hash of the sources that the digits of a reference depend on besides the core and the cases.

fn main() {
    rimbench_sources::bake("RIMBENCH_RUNS_SOURCES", &["reference.rs"]);
}
