runs <- read.csv("runs.csv", colClasses = c(run_id = "character"))
completed <- subset(runs, outcome == "completed")
print(aggregate(force_error_rms_n ~ case + label + macro_step_s, data = completed, FUN = median))
