//! The board's own pose, from its jack channels, while the stream carries it.
//!
//! The link hands over the jacks of each block that it has sent; the latest block replaces one that was not taken. So the
//! sample path does not know of poses, the board spends nothing on poses that no host wants, and a pose never comes before
//! its block. This task runs in thread mode, below sample path and link, and solves a hundred times a
//! second at most.
//!
//! A solve starts from the last pose. After a pause, in which the base may have moved, after a refusal and with another
//! set it starts from home.

use embassy_time::{Instant, Timer, with_timeout};
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::{BaseError, SetId};
use hexsense_core::wire::{BoardPose, PoseRefusal, PoseReport};

use crate::chip::timing::{HEARTBEAT, POSE_PAUSE, POSE_PERIOD};
use crate::shared::{Shared, Task};

/// Finds poses for ever.
#[embassy_executor::task]
pub async fn find(shared: &'static Shared) -> ! {
    // There is a receiver for this task, which starts once.
    let mut base = shared.base.receiver().expect("a receiver is left");
    let mut active: Option<(SetId, Result<Tracker<f32>, BaseError>)> = None;
    let mut last = Instant::MIN;
    loop {
        shared.alive.sign(Task::Pose);
        let Ok(block) = with_timeout(HEARTBEAT, shared.jacks.wait()).await else {
            continue;
        };
        let now = Instant::now();
        if let Some(base) = base.try_changed() {
            active = base.map(|base| {
                (
                    base.set,
                    Tracker::new(&base.base, &base.jacks, base.ratiometric),
                )
            });
        }
        // Without a set the link refuses poses.
        let Some((set, tracker)) = &mut active else {
            continue;
        };
        let outcome = match tracker {
            Ok(tracker) => {
                if now.saturating_duration_since(last) > POSE_PAUSE {
                    tracker.restart();
                }
                solve(tracker, &block)
            }
            Err(error) => Err(PoseRefusal::Base(*error)),
        };
        last = now;
        shared.pose.signal(PoseReport {
            first_scan: block.first_scan,
            block: block.block,
            set: *set,
            outcome,
        });
        Timer::at(now + POSE_PERIOD).await;
    }
}

/// One pose. Its instructions are counted on the virtual board by this symbol.
// SAFETY: no other symbol of the program has this name.
#[unsafe(export_name = "solve_pose")]
#[inline(never)]
fn solve(tracker: &mut Tracker<f32>, block: &JackBlock) -> Result<BoardPose, PoseRefusal> {
    tracker
        .next(block)
        .map(BoardPose::from)
        .map_err(PoseRefusal::from)
}
