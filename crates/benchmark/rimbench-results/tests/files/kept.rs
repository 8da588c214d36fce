//! What is kept of results, and checksums of all.

use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_results::checksums::{CHECKSUMS, sha256, verify, verify_with, write};
use rimbench_results::kept::{DIGEST, Digest, PooledSets, SUMMARY, keep, read_summary};

/// Files with their checksums.
fn summed() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("traces")).unwrap();
    for name in ["runs.csv", "cost.csv", "traces/a.csv"] {
        std::fs::write(folder.path().join(name), name).unwrap();
    }
    write(folder.path(), ["runs.csv", "cost.csv", "traces/a.csv"].map(str::to_owned)).unwrap();
    folder
}

#[test]
fn the_checksum_of_nothing_is_the_known_one() {
    assert_eq!(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

#[test]
fn whatever_is_changed_or_missing_is_named() {
    let folder = summed();
    verify(folder.path()).unwrap();
    let refused = || verify(folder.path()).unwrap_err().to_string();
    for name in ["runs.csv", "cost.csv", "traces/a.csv"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "other").unwrap();
        assert!(refused().contains(&format!("{name} has been changed")), "{}", refused());
        std::fs::remove_file(&path).unwrap();
        assert!(refused().contains(&format!("{name} is missing")), "{}", refused());
        std::fs::write(&path, name).unwrap();
    }
    verify(folder.path()).unwrap();
    for text in ["", "not a checksum\n", "0000  ../runs.csv\n"] {
        std::fs::write(folder.path().join(CHECKSUMS), text).unwrap();
        assert!(refused().contains(CHECKSUMS), "{}", refused());
    }
    std::fs::remove_file(folder.path().join(CHECKSUMS)).unwrap();
    assert!(refused().contains("run the experiment again"));
    write(folder.path(), ["cost.csv".to_owned()]).unwrap();
    assert!(refused().contains("missing or empty"));
    verify_with(folder.path(), "cost.csv", "look again").unwrap();
    std::fs::write(folder.path().join("cost.csv"), "other").unwrap();
    let said = verify_with(folder.path(), "cost.csv", "look again").unwrap_err().to_string();
    assert!(said.ends_with("cost.csv has been changed; look again"), "{said}");
}

const RUNS: &str = "run_id,label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n,position_error_rms_m\n\
                    1,x,box,,0.005,,completed,1,1e-3\n2,x,box,,0.005,,completed,3,\n3,x,box,,0.005,,diverged,1e9,1\n\
                    4,y,box,,0.005,,timeout,,\n";

fn results() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("runs.csv"), RUNS).unwrap();
    keep(folder.path(), &PooledSets::new(), &"0".repeat(64)).unwrap();
    folder
}

#[test]
fn quartiles_are_those_of_the_completed_runs_and_are_read_back() {
    let folder = results();
    let rows = read_summary(folder.path()).unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!((rows[0].runs, rows[0].completed, rows[0].quartiles[0]), (3, 2, [1.5, 2.0, 2.5]));
    assert_eq!(rows[0].quartiles[4], [1e-3; 3]);
    assert_eq!((rows[1].runs, rows[1].completed, rows[1].keys[2].as_str()), (1, 0, "y"));
    assert!(rows[1].quartiles.as_flattened().iter().all(|value| value.is_nan()));
    // A run that took too long is no failure.
    assert_eq!([&rows[0], &rows[1]].map(|row| [row.failed, row.no_answer]), [[1, 0], [0, 1]]);
    let digest = Digest::read(folder.path()).unwrap();
    assert_eq!(digest.rows, 4);
    digest.check_rows(folder.path()).unwrap();
}

#[test]
fn drawn_settings_are_one_row_with_the_error_that_has_no_unit_and_the_worst() {
    let folder = tempfile::tempdir().unwrap();
    let mut runs = String::from(
        "run_id,label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n,force_error_rms_of_peak\n",
    );
    let mut pooled = PooledSets::new();
    for (mass, outcome) in [(1, "completed"), (2, "completed"), (3, "completed"), (4, "diverged"), (5, "skipped")] {
        for case in ["a", "b"] {
            let set = format!("e=0.3 mass={mass}");
            runs += &format!("r,x,{case},{set},0.005,,{outcome},9,0.0{mass}\n");
            pooled.insert((case.to_owned(), set), "e=0.3".to_owned());
        }
    }
    std::fs::write(folder.path().join("runs.csv"), runs).unwrap();
    keep(folder.path(), &pooled, &"0".repeat(64)).unwrap();
    let rows = read_summary(folder.path()).unwrap();
    assert_eq!(
        rows.iter().map(|row| [&*row.keys[0], &*row.keys[1]]).collect::<Vec<_>>(),
        [["a", "e=0.3"], ["b", "e=0.3"]]
    );
    assert_eq!((rows[0].runs, rows[0].completed, rows[0].worst), (4, 3, Some(0.03)));
    assert!(rows[0].quartiles[0].iter().all(|value| value.is_nan()));
    assert_eq!(rows[0].quartiles[1], [0.015, 0.02, 0.025]);
}

#[test]
fn what_is_damaged_of_another_version_or_of_other_rows_is_named() {
    let folder = results();
    let path = |name: &str| folder.path().join(name);
    let [summary, digest] = [SUMMARY, DIGEST].map(|name| std::fs::read_to_string(path(name)).unwrap());
    std::fs::write(path(SUMMARY), summary.replace("2.0", "2.1")).unwrap();
    assert!(read_summary(folder.path()).unwrap_err().to_string().contains("is not that of digest.toml"));
    std::fs::write(path(SUMMARY), &summary).unwrap();
    for (change, said) in [
        (
            digest.replace(&format!("numerics_version = {NUMERICS_VERSION}"), "numerics_version = 1"),
            "of numerics version 1",
        ),
        (digest.replace("rows", "lines"), "is no digest"),
        (digest.replace("runs_sha256 = \"", "runs_sha256 = \"z"), "is no SHA-256"),
    ] {
        std::fs::write(path(DIGEST), change).unwrap();
        let error = read_summary(folder.path()).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    std::fs::write(path(DIGEST), &digest).unwrap();
    std::fs::write(path("runs.csv"), RUNS.replace("1e9", "1e8")).unwrap();
    let error = Digest::read(folder.path()).unwrap().check_rows(folder.path()).unwrap_err().to_string();
    assert!(error.contains("is not that of digest.toml"), "{error}");
}
