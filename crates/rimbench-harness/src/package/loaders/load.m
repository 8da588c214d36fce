options = detectImportOptions("runs.csv", "TextType", "string");
options = setvartype(options, ["run_id", "label", "set", "reason", "trace"], "string");
runs = readtable("runs.csv", options);
completed = runs(runs.outcome == "completed", :);
disp(groupsummary(completed, ["case", "label", "macro_step_s"], "median", "force_error_rms_n"))
