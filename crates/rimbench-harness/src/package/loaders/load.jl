using CSV, DataFrames, Statistics

runs = CSV.read("runs.csv", DataFrame; types = Dict(:run_id => String))
completed = filter(row -> row.outcome == "completed", runs)
println(combine(groupby(completed, [:case, :label, :macro_step_s]), :force_error_rms_n => median))
