//! Files with any number replaced by any other thing: refused with the file's name, or used; never a panic.

use geometries::PRESETS;
use hexsense_probe::capture::Capture;
use hexsense_probe::geometry_file::GeometryFile;
use hexsense_probe::plan::{Plan, campaign, limits};
use hexsense_probe::sensor_file::SensorFile;

const INSTEAD: [&str; 9] = [
    "nan",
    "-inf",
    "-1.0",
    "0.0",
    "7",
    "1e300",
    "99999999999999999999",
    "\"\"",
    "[]",
];

/// Every text in which one number of `text` is something else, comments left out.
fn variants(text: &str) -> Vec<String> {
    let is_number = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
    let mut variants = Vec::new();
    let mut from = 0;
    while let Some(start) = text[from..]
        .find(|c: char| c.is_ascii_digit())
        .map(|at| from + at)
    {
        let end = text[start..]
            .find(|c| !is_number(c))
            .map_or(text.len(), |at| start + at);
        for instead in INSTEAD {
            variants.push(format!("{}{instead}{}", &text[..start], &text[end..]));
        }
        from = end;
    }
    variants
}

/// Tries `read` on every variant of `text`; what is refused must be named.
fn try_all<T, E: std::fmt::Display>(text: &str, read: impl Fn(&str) -> Result<T, E>) {
    let variants = variants(text);
    assert!(variants.len() > 100);
    let mut refused = 0;
    for variant in &variants {
        if let Err(error) = read(variant) {
            assert!(error.to_string().starts_with("FILE"), "{error}");
            refused += 1;
        }
    }
    assert!(
        refused > variants.len() / 3,
        "{refused} of {} were refused",
        variants.len()
    );
}

#[test]
fn of_a_geometry_file() {
    for (_, text) in PRESETS {
        try_all(text, |text| GeometryFile::parse("FILE", text));
    }
}

#[test]
fn of_a_sensor_file() {
    try_all(&twin::papers::sensor_file(1), |text| {
        SensorFile::parse("FILE", text)
    });
}

#[test]
fn of_a_plan() {
    let geometry = GeometryFile::load("an-74tk-200").unwrap();
    let plan = campaign::plan(&geometry).unwrap();
    try_all(&plan.to_toml(), |text| {
        let mut plan = Plan::parse("FILE", text)?;
        // What the limits cost is the length of the runs; the variant is in one of them.
        plan.period_s = plan.period_s.max(0.02);
        let _ = limits::check(&plan, &geometry);
        Ok::<_, hexsense_probe::files::FileError>(plan)
    });
}

#[test]
fn of_a_capture() {
    let mut text = String::from(
        "scan,ax,ay,az,ex,ey,ez,wx,wy,wz,jack1,jack2,jack3,jack4,jack5,jack6,supply,temperature_c\n",
    );
    for scan in 10..14 {
        text += &format!("{scan},1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,0.998,31.25\n");
    }
    try_all(&text, |text| Capture::parse("FILE", text));
}
