//! Every timing constant of the board that needs a driver's type, with its reason; clock and converter settings are in
//! the library of this package.
//!
//! The clock has ticks of 10 µs. A wait may end a tick early, because it begins within one.

use embassy_stm32::adc::SampleTime;
use embassy_time::Duration;
use hexsense::{OVERSAMPLING, SAMPLING_HALF_CYCLES};
use hexsense_core::sampling::BlockSize;
use hexsense_core::wire::{pose, telemetry};

/// Code of the oversampling ratio in the register ADC_CFGR2.OVSR, for 2^(code + 1).
pub const OVERSAMPLING_CODE: u8 = OVERSAMPLING.trailing_zeros() as u8 - 1;

/// Sampling time of one conversion.
pub const SAMPLE_TIME: SampleTime = SampleTime::CYCLES47_5;

const _: () = assert!(
    SAMPLING_HALF_CYCLES == 95,
    "the sampling time is not that of the library"
);

/// From starting the timer to the first trigger, µs: time for nothing more than to start, and well below the pause of
/// 1 ms after which a conversion may be wrong.
pub const FIRST_TRIGGER_US: u32 = 100;

/// How long to wait for a block before the converters count as stuck: three blocks, and not so short that looking costs
/// more than sampling.
pub fn block_timeout(rate_hz: u32, block: BlockSize) -> Duration {
    let blocks = Duration::from_micros(3 * block.scans() as u64 * 1_000_000 / u64::from(rate_hz));
    blocks.max(Duration::from_millis(10))
}

/// How often to look for the first block after a command; the answer waits for it.
pub const FIRST_BLOCK_POLL: Duration = Duration::from_millis(1);

/// Supply and temperature change over seconds; ten readings a second leave room for averaging. Each may end a frame
/// early; the link's capacity is planned for that.
pub const SUPPLY_PERIOD: Duration = Duration::from_hz(telemetry::SUPPLY_HZ as u64);
/// How long a reading may take: three times 256 conversions of 17.4 µs are 13.4 ms.
pub const SUPPLY_WAIT: Duration = Duration::from_millis(50);
/// Start of the temperature sensor and the reference buffer: 120 µs in the data sheet.
pub const INTERNAL_START: Duration = Duration::from_millis(1);

/// From one pose to the next at least; the link's capacity is planned for that.
pub const POSE_PERIOD: Duration = Duration::from_hz(pose::MAX_RATE_HZ as u64);
/// After so long without a pose the next starts from home: a base that moves at 1 m/s is then 5 cm away, which is as
/// far as tracking goes.
pub const POSE_PAUSE: Duration = Duration::from_millis(50);

/// Bytes that the receiver's ring holds. While a longest frame goes out, 6 ms, at most 1200 bytes come in.
pub const RECEIVE_RING: usize = 1_280;

/// After everything that had come was taken, so long passes until more is taken: at most a hundred bytes, which cost
/// little together. Taken one by one, a line that is never idle would keep the link at work without a break, and all of
/// thread mode waiting until the watchdog bites.
pub const GATHER: Duration = Duration::from_micros(500);

/// How long the receiver is off after an error, in which the link goes on sending. A line full of noise then costs the
/// core a thousand errors a second at most.
pub const DEAF_AFTER_ERROR: Duration = Duration::from_millis(1);

/// From the end of a transmission's DMA to that of its last character: eight in the FIFO and one on the line take 45 µs.
pub const LAST_CHARACTERS: Duration = Duration::from_micros(50);

/// The watchdog resets a board of which a part makes no progress for so long: longer than the slowest flash
/// operation (a page is erased in 22 ms, and a commit may need several), shorter than a user's patience.
pub const WATCHDOG_US: u32 = 1_000_000;
/// How often the watchdog is fed at most.
pub const SUPERVISOR_PERIOD: Duration = Duration::from_millis(100);
/// How often the supervisor looks whether all tasks have made progress, when some have not.
pub const SUPERVISOR_LOOK: Duration = Duration::from_millis(10);
/// How often a task that has nothing to do says that it is alive.
pub const HEARTBEAT: Duration = Duration::from_millis(100);
/// How often the coefficients at work are compared with the stored set.
pub const COEFFICIENT_CHECK: Duration = Duration::from_secs(1);
/// How often to look for a random number, and how many times before there is none: the generator makes the first four in
/// 9 µs and needs 1 µs for every other four (RM0440, 26.5); its oscillator starts in 6 µs (DS12288).
pub const RANDOM_LOOK: Duration = Duration::from_micros(10);
/// See [`RANDOM_LOOK`].
pub const RANDOM_LOOKS: u32 = 100;
/// How long the crystal may take to start, ms: ten times what its data sheet says.
pub const CRYSTAL_START_MS: u32 = 20;
