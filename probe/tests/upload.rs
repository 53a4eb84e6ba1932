//! What `hexsense upload` looks at before it stores a set: the file itself, and what it was found from.

mod fake;

use std::fs;
use std::path::PathBuf;

use fake::bench::Bench;

struct Desk {
    bench: Bench,
    folder: PathBuf,
}

impl Desk {
    /// A finished campaign, with a line end as people have it in the plan.
    fn calibrated() -> Self {
        let bench = Bench::new(|_| {});
        assert!(bench.record("calibrate").status.success());
        let folder = bench.folder.path().join("campaign");
        Self { bench, folder }
    }

    /// Uploads while a file is changed; whether that succeeds, and what is said.
    fn upload_with(&self, file: &str, change: impl FnOnce(&str) -> String) -> (bool, String) {
        let path = self.folder.join(file);
        let kept = fs::read_to_string(&path).unwrap();
        let changed = change(&kept);
        assert_ne!(changed, kept, "{file}");
        fs::write(&path, changed).unwrap();
        let said = self.upload();
        fs::write(&path, kept).unwrap();
        said
    }

    fn upload(&self) -> (bool, String) {
        let output = self.bench.hexsense(&["upload", "campaign"]);
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.success(), said)
    }

    fn log(&self) -> Vec<u8> {
        self.bench.hexsense(&["log", "--json"]).stdout
    }
}

#[test]
fn a_set_is_uploaded_only_beside_what_it_was_found_from() {
    let desk = Desk::calibrated();
    let before = desk.log();
    let one_row_less = |text: &str| {
        let (rows, _) = text.trim_end().rsplit_once('\n').unwrap();
        format!("{rows}\n")
    };
    let refused = |file: &str, named: &str, change: &dyn Fn(&str) -> String| {
        let (done, said) = desk.upload_with(file, change);
        let told = format!("campaign/{named} is not what the coefficients were found from");
        assert!(!done && said.contains(&told), "{file}: {said}");
    };
    refused("sensors.toml", "sensors.toml", &|text| {
        format!("{text}# \n")
    });
    refused("geometry.toml", "geometry.toml", &|text| {
        format!("{text}# \n")
    });
    refused("plan.toml", "plan.toml", &|text| {
        text.replacen("20.0", "19.0", 1)
    });
    for run in ["zero", "heave", "pitch-sine"] {
        refused(&format!("captures/{run}.csv"), "captures", &one_row_less);
    }
    let (done, said) = desk.upload_with("coefficients.toml", |text| {
        text.replacen("offset_counts = [3", "offset_counts = [4", 1)
    });
    assert!(!done && said.contains("changed or damaged"), "{said}");
    assert_eq!(desk.log(), before, "nothing has changed on the board");

    let (done, said) = desk.upload_with("sensors.toml", |text| text.replace('\n', "\r\n"));
    assert!(done && !said.contains("not checked"), "{said}");
}

#[test]
fn what_is_not_there_is_told_as_not_checked() {
    let desk = Desk::calibrated();
    for (file, told) in [
        (
            "sensors.toml",
            "not checked: sensors.toml, which is not there",
        ),
        ("geometry.toml", "not checked: the movements of plan.toml"),
        (
            "plan.toml",
            "not checked: the captures, which the plan names",
        ),
        (
            "captures/heave.csv",
            "not checked: the captures: captures/heave.csv",
        ),
    ] {
        let [path, aside] = [file, "aside"].map(|name| desk.folder.join(name));
        fs::rename(&path, &aside).unwrap();
        let (done, said) = desk.upload();
        assert!(done && said.contains(told), "{file}: {said}");
        fs::rename(&aside, &path).unwrap();
    }
    let (done, said) = desk.upload();
    assert!(done && said.is_empty(), "{said}");
}
