//! `hexsense info`: who the board is and how it is.

use clap::Args;
use hexsense::sampling::NOMINAL_SUPPLY_V;
use hexsense::wire::VERSION;

use super::arguments::Port;
use crate::files;

/// Print who the board is and how it is: versions, clock, supply, temperature, losses, coefficients.
#[derive(Args)]
pub struct Info {
    #[command(flatten)]
    port: Port,
}

impl Info {
    /// Runs the command.
    ///
    /// # Errors
    /// What the link reports.
    pub fn run(self) -> anyhow::Result<()> {
        let mut client = self.port.open()?;
        let identity = client.identity()?;
        let status = client.status()?;
        let active = client.active_set()?;
        let [major, minor, patch] = client.firmware();
        println!(
            "board          {} ({})",
            files::hex(&identity.board),
            identity.hardware
        );
        println!(
            "firmware       {major}.{minor}.{patch}, wire version {}",
            VERSION
        );
        println!(
            "last start     {:?}, {:.1} s ago",
            identity.reset,
            status.uptime_ms as f64 / 1000.0
        );
        if let Some(panic) = &status.panic {
            println!("panic          {panic}");
        }
        println!(
            "clock          {}",
            if status.crystal {
                "crystal"
            } else {
                "internal oscillator, about 1 % off: not fit to calibrate"
            }
        );
        println!("supply         {:.3} V", status.supply * NOMINAL_SUPPLY_V);
        println!(
            "temperature    {:.1} °C{}",
            status.temperature_c,
            if active.is_some() && !status.in_calibrated_range {
                ", outside the calibrated range"
            } else {
                ""
            }
        );
        println!(
            "scans          {} at {} Hz, {} lost",
            status.scans, status.rate_hz, status.scans_lost
        );
        println!(
            "link           {} blocks dropped, {} damaged frames",
            status.blocks_dropped, status.frames_damaged
        );
        if let Some([roll, pitch]) = status.tilt_approximate_rad {
            println!(
                "tilt, rough    roll {:.1}°, pitch {:.1}°",
                roll.to_degrees(),
                pitch.to_degrees()
            );
        }
        match active {
            Some(set) => println!("coefficients   set {}, commit {}", set.id, set.sequence),
            None => println!("coefficients   none; calibrate and upload a set"),
        }
        Ok(())
    }
}
