//! Bakes in a hash of the sources that the digits of a reference depend on besides the core.

fn main() {
    rimbench_sources::bake("RIMBENCH_CASES_SOURCES", &["models", "cases", "parameter"]);
}
