import pandas as pd

runs = pd.read_csv("runs.csv", dtype={"run_id": str})
completed = runs[runs["outcome"] == "completed"]
print(completed.groupby(["case", "label", "macro_step_s"])["force_error_rms_n"].median())
