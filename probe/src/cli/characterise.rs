//! `hexsense characterise`: measurements of the motion system, beside the calibration.

use std::path::PathBuf;

use clap::Args;

use super::arguments::{Controller, Port, Waiting};
use super::broken_off::typed;
use super::progress;
use crate::campaign::{Begun, Campaign, Given};
use crate::characteristics::Characteristics;
use crate::evaluation::characterise;
use crate::interrupt::Interrupt;
use crate::plan::{Purpose, Run};
use crate::record::board::{board_record, ready};
use crate::record::run::Settings;
use crate::record::sequence::SequenceJob;
use crate::terminal::{self, say};

/// Measure the motion system itself: how the pose of the base follows the command.
///
/// Records the runs of the campaign's plan whose purpose is "characterise" (add them to FOLDER/plan.toml; they are
/// checked against the limits of the base like all others) and writes characteristics.json. A run in which one sine moves
/// one degree of freedom gives a frequency response, and so does every such run of `calibrate`; of other movements the
/// recording is kept. No coefficient changes, on the board or in the folder. `hexsense report` then shows what was found.
///
/// A run that is recorded already is not recorded again. Ctrl-C stops the run under way; the command that hexsense then
/// prints records it again.
#[derive(Args)]
pub struct Characterise {
    #[command(flatten)]
    port: Port,
    /// Folder of the campaign, begun by `hexsense calibrate`
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    #[command(flatten)]
    controller: Controller,
    #[command(flatten)]
    waiting: Waiting,
}

impl Characterise {
    /// Runs the command.
    ///
    /// # Errors
    /// Files, link, motion controller and analysis.
    pub fn run(self) -> anyhow::Result<()> {
        let (campaign, begun) = Given::default().resume(&self.folder)?;
        campaign.first_run_to(Purpose::Characterise)?;
        let runs: Vec<&Run> = campaign.plan.runs_to(Purpose::Characterise).collect();
        self.record(&campaign, &begun, &runs)?;
        let fitted = campaign.plan.runs_to(Purpose::Calibrate);
        let fitted = fitted
            .filter(|run| campaign.is_recorded(&run.name))
            .map(|run| campaign.recorded(run))
            .collect::<Result<Vec<_>, _>>()?;
        let found = characterise(&campaign, &fitted)?.characteristics;
        terminal::print(&table(&found))?;
        campaign.note_characteristics(&found)?;
        let folder = campaign.folder.display();
        say!("written: {folder}/characteristics.json")?;
        if campaign.coefficients_path().is_ok() {
            say!("next: hexsense report {folder}, to see it in the report")?;
        }
        Ok(())
    }

    fn record(&self, campaign: &Campaign, begun: &Begun, runs: &[&Run]) -> anyhow::Result<()> {
        let interrupt = Interrupt::on_signals()?;
        let mut client = self.port.open()?;
        let identity = ready(&mut client, begun.rate_hz)?;
        campaign.check_board(&board_record(&client, &identity))?;
        let mut motion = self.controller.motion(&interrupt)?;
        campaign.write()?;
        let job = SequenceJob {
            campaign,
            runs,
            settings: Settings {
                rate_hz: begun.rate_hz,
                values: false,
            },
            board: identity.board,
            wait: self.waiting.time(),
            interrupt: &interrupt,
        };
        let again = format!(
            "hexsense characterise {} --port {}{}{}",
            typed(&campaign.folder),
            self.port.port,
            self.controller.again(),
            self.waiting.again(),
        );
        progress::record(&job, &mut client, motion.as_mut(), &again)?;
        Ok(())
    }
}

/// The frequency responses as a table.
fn table(found: &Characteristics) -> String {
    let mut text = String::from("\nrun          moved    frequency, Hz  ratio    phase, °\n");
    for response in &found.frequency_response {
        text += &format!(
            "{:<12} {:<8} {:>13.5} {:>6.4} {:>11.2}\n",
            response.run,
            response.freedom,
            response.frequency_hz,
            response.ratio,
            response.phase_deg,
        );
    }
    text + "the pose by the jacks against the command; a delay that all jacks share does not show\n\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characteristics::frequency_response::FrequencyResponse;

    #[test]
    fn frequency_ratio_and_phase_with_its_sign_stand_in_the_order_of_the_head() {
        let response =
            |run: &str, freedom: &str, frequency_hz, ratio, phase_deg| FrequencyResponse {
                run: run.to_owned(),
                freedom: freedom.to_owned(),
                frequency_hz,
                command: 0.05,
                measured: 0.06,
                ratio,
                phase_deg,
                distortion: 0.07,
            };
        let found = Characteristics {
            frequency_response: vec![
                response("slow-heave", "heave", 0.25012, 0.97, -12.345_6),
                response("roll-sine", "roll", 0.50123, 1.025, 3.21),
            ],
        };
        let expected = "
run          moved    frequency, Hz  ratio    phase, °
slow-heave   heave          0.25012 0.9700      -12.35
roll-sine    roll           0.50123 1.0250        3.21
the pose by the jacks against the command; a delay that all jacks share does not show

";
        assert_eq!(table(&found), expected);
    }
}
