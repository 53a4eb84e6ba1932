//! `hexsense harmonics`: what the board itself finds at the drive frequency.

use clap::Args;
use hexsense_core::channel::{CHANNELS, INERTIAL, NAMES};
use hexsense_core::harmonics::HARMONICS;
use hexsense_core::live_motion::Motion;
use hexsense_core::wire::message::ChannelHarmonics;
use hexsense_core::wire::{Drive, PoseRefusal, Refusal};
use serde_json::{Value, json};

use super::arguments::Port;
use crate::figure::number::{rounded, significant};
use crate::terminal;
use hexsense_client::{Client, LinkError};

/// Coordinates of a motion with their units.
const COORDINATES: [(&str, &str); 6] = [
    ("X", "m"),
    ("Y", "m"),
    ("Z", "m"),
    ("roll", "rad"),
    ("yaw", "rad"),
    ("pitch", "rad"),
];
/// Units of the three kinds of sensors.
const UNITS: [&str; 3] = ["m/s²", "rad/s²", "rad/s"];
/// An axis counts as driven when it moves at least this part of the largest movement of its kind.
const DRIVEN: f32 = 0.1;

/// Print what the board itself finds at the drive frequency of one analyser.
///
/// For all fifteen channels these are offset, drift, amplitude and phase with their standard uncertainties, distortion and
/// residual, in counts. A board with coefficients knows its base; then the movement of the base and the calibration factor
/// of each driven sensor are printed too.
///
/// The analyser must be complete: `hexsense status` says so, and each sine run of `calibrate` or `verify` leaves it
/// that way until the next begins.
#[derive(Args)]
pub struct Harmonics {
    #[command(flatten)]
    port: Port,
    /// Which of the three analysers, 0 to 2
    #[arg(long, value_name = "N", default_value_t = 0)]
    analyser: u8,
    /// Print one JSON document, with all five harmonics
    #[arg(long)]
    json: bool,
}

impl Harmonics {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports, and sums that are not complete.
    pub fn run(self) -> anyhow::Result<()> {
        let text = text(&mut self.port.open()?, self.analyser, self.json)?;
        Ok(terminal::print(&text)?)
    }
}

/// What the command prints of a board and one of its analysers, 0 to 2.
///
/// # Errors
/// What the link reports.
pub fn text(client: &mut Client, analyser: u8, json: bool) -> anyhow::Result<String> {
    let found = Found::ask(client, analyser)?;
    Ok(match json {
        true => format!("{}\n", found.to_json()),
        false => found.table(),
    })
}

/// The board's answers.
struct Found {
    rate_hz: u32,
    drive: Drive,
    first_scan: u64,
    fits: Vec<ChannelHarmonics>,
    /// `None` without coefficients.
    motion: Option<Result<Motion, PoseRefusal>>,
}

impl Found {
    fn ask(client: &mut Client, analyser: u8) -> Result<Self, LinkError> {
        let rate_hz = client.status()?.rate_hz;
        let first = client.harmonics(analyser, 0)?;
        let mut fits = vec![first.harmonics];
        for channel in 1..CHANNELS as u8 {
            fits.push(client.harmonics(analyser, channel)?.harmonics);
        }
        let motion = match client.motion(analyser) {
            Ok(motion) => Some(motion),
            Err(LinkError::Refused(Refusal::NoSet)) => None,
            Err(error) => return Err(error),
        };
        Ok(Self {
            rate_hz,
            drive: first.drive,
            first_scan: first.first_scan,
            fits,
            motion,
        })
    }

    fn seconds(&self) -> f64 {
        let scans = f64::from(self.drive.blocks) * self.drive.block.scans() as f64;
        scans / f64::from(self.rate_hz)
    }

    fn table(&self) -> String {
        let frequency_hz = self.drive.frequency_hz(self.rate_hz);
        let mut text = format!(
            "{frequency_hz:.6} Hz over {:.3} s from scan {}, in blocks of {}; counts, ± standard uncertainty\n\n\
             {:<8}{:>20}{:>18}{:>22}{:>22}{:>11}{:>10}\n",
            self.seconds(),
            self.first_scan,
            self.drive.block.scans(),
            "channel",
            "offset",
            "drift",
            "amplitude",
            "phase, rad",
            "THD, %",
            "rms"
        );
        for (name, fit) in NAMES.iter().zip(&self.fits) {
            let uncertainty = &fit.uncertainty;
            let row = format!(
                "{name:<8}{:>20}{:>18}{:>22}{:>22}{:>11}{:>10}\n",
                pair(fit.offset, uncertainty.offset),
                pair(fit.drift, uncertainty.drift),
                pair(fit.amplitude[0], uncertainty.amplitude[0]),
                pair(fit.phase[0], uncertainty.phase[0]),
                significant(100.0 * fit.distortion, 3),
                significant(fit.residual_rms, 3),
            );
            text.push_str(&row);
        }
        text + &self.motion_text()
    }

    fn motion_text(&self) -> String {
        match &self.motion {
            None => "\nno motion: the board has no coefficients; calibrate and upload a set\n"
                .to_owned(),
            Some(Err(refusal)) => format!("\nno motion: {refusal}\n"),
            Some(Ok(motion)) => {
                let moved = COORDINATES.iter().zip(motion.amplitude);
                let moved = moved.map(|((name, unit), amplitude)| {
                    format!("{name} {} {unit}", significant(amplitude.into(), 5))
                });
                let moved: Vec<String> = moved.collect();
                let mut text = format!("\nmotion by the jacks: {}\n", moved.join(", "));
                for channel in driven(motion) {
                    let factor = f64::from(motion.factors[channel]);
                    let unit = UNITS[channel / 3];
                    text += &format!("{:<8}{factor:.5e} {unit} per count\n", NAMES[channel]);
                }
                text
            }
        }
    }

    fn to_json(&self) -> Value {
        let channels = NAMES.iter().zip(&self.fits).map(|(name, fit)| {
            let harmonics = (0..HARMONICS).map(|k| {
                json!({
                    "amplitude": fit.amplitude[k],
                    "amplitude_uncertainty": fit.uncertainty.amplitude[k],
                    "phase_rad": fit.phase[k],
                    "phase_uncertainty_rad": fit.uncertainty.phase[k],
                })
            });
            json!({
                "channel": name,
                "offset": fit.offset,
                "offset_uncertainty": fit.uncertainty.offset,
                "drift": fit.drift,
                "drift_uncertainty": fit.uncertainty.drift,
                "harmonics": harmonics.collect::<Vec<_>>(),
                "distortion": fit.distortion,
                "residual_rms": fit.residual_rms,
            })
        });
        json!({
            "frequency_hz": self.drive.frequency_hz(self.rate_hz),
            "first_scan": self.first_scan,
            "block": self.drive.block.scans(),
            "blocks": self.drive.blocks,
            "channels": channels.collect::<Vec<_>>(),
            "motion": self.motion.as_ref().map(motion_json),
        })
    }
}

fn motion_json(motion: &Result<Motion, PoseRefusal>) -> Value {
    match motion {
        Err(refusal) => json!({"refusal": refusal.to_string()}),
        Ok(motion) => {
            let factors = driven(motion).map(|channel| {
                json!({
                    "channel": NAMES[channel],
                    "per_count": motion.factors[channel],
                    "unit": UNITS[channel / 3],
                })
            });
            json!({
                "displacement_m": motion.amplitude[..3],
                "rotation_rad": motion.amplitude[3..],
                "factors": factors.collect::<Vec<_>>(),
            })
        }
    }
}

/// Channels whose axis was driven.
fn driven(motion: &Motion) -> impl Iterator<Item = usize> {
    let most = |kind: usize| {
        motion.amplitude[3 * kind..][..3]
            .iter()
            .fold(0.0, |a, b| f32::max(a, *b))
    };
    let most = [most(0), most(1)];
    let amplitude = motion.amplitude;
    // Rotation drives two kinds of sensors.
    (0..INERTIAL).filter(move |channel| {
        let kind = (channel / 3).min(1);
        amplitude[3 * kind + channel % 3] >= DRIVEN * most[kind]
    })
}

fn pair(value: f64, uncertainty: f64) -> String {
    let [value, uncertainty] = rounded(value, uncertainty);
    format!("{value} ± {uncertainty}")
}

#[cfg(test)]
mod tests;
