//! Every timing constant of the board, with its reason.
//!
//! The chain from crystal to sample is exact: 24 MHz · 25 / 4 = 150 MHz; TIM6 divides that by 4 and by a whole
//! number for each rate; so 1, 2 and 4 kHz are what they say, to the crystal's tolerance.

use embassy_stm32::adc::SampleTime;
use embassy_time::Duration;
use hexsense_core::channel::{COUNTS_AT_SUPPLY, INERTIAL};
use hexsense_core::sampling::{BlockSize, RANK_NS, RATES_HZ};
use hexsense_core::wire::{pose, telemetry};

/// Core and bus clock, Hz. 150 MHz is the most that needs no core boost, and all rates divide it.
pub const CORE_HZ: u32 = 150_000_000;
/// Clock of the converters, Hz: the PLL's 300 MHz divided by 8, a quarter of the core's. Their limit is 60 MHz for one
/// alone and 52 MHz with all running, and a sixth of 300 MHz would leave the pins' filters too little time.
pub const ADC_HZ: u32 = CORE_HZ / 4;

/// Conversions that the hardware adds up into one count.
pub const OVERSAMPLING: u32 = 16;
/// Code of that ratio in the register ADC_CFGR2.OVSR, for 2^(code + 1).
pub const OVERSAMPLING_CODE: u8 = 3;

/// Sampling time of one conversion: the longest that fits nine channels into the shortest period, so that the pins'
/// filters have the most time to charge the sampling capacitor (1.27 µs).
pub const SAMPLE_TIME: SampleTime = SampleTime::CYCLES47_5;
/// Cycles of the converter's clock for one conversion: 47.5 of sampling and 12.5 of approximation.
pub const CONVERSION_CYCLES: u32 = 60;
/// Duration of a whole scan, ns: nine ranks of ADC1, while ADC2 does six beside them.
pub const SCAN_NS: u32 = RANK_NS * INERTIAL as u32;

/// Prescaler of TIM6: without it a period of 1 kHz does not fit into 16 bits. As the converters' clock is a quarter of
/// the core's, every trigger meets it in the same phase.
pub const TRIGGER_PRESCALER: u32 = 4;

/// Cycles of the prescaled timer clock in one period at `rate_hz`.
pub const fn trigger_ticks(rate_hz: u32) -> u32 {
    CORE_HZ / TRIGGER_PRESCALER / rate_hz
}

/// A converter that was triggered while still busy ignores the trigger, and the rate would halve without a sign.
/// So a scan must fit the period, with 5 % to spare. The host corrects the ranks' delays by the core's constant.
const _: () = {
    let rank_cycles = (CONVERSION_CYCLES * OVERSAMPLING) as u64;
    assert!(
        RANK_NS as u64 * ADC_HZ as u64 == rank_cycles * 1_000_000_000,
        "the core assumes another duration of a rank"
    );
    assert!(
        2 << OVERSAMPLING_CODE == OVERSAMPLING,
        "the ratio is not its code"
    );
    assert!(
        COUNTS_AT_SUPPLY == 4_096 * OVERSAMPLING,
        "the core assumes another count"
    );
    let mut i = 0;
    while i < RATES_HZ.len() {
        let rate = RATES_HZ[i];
        assert!(
            CORE_HZ.is_multiple_of(TRIGGER_PRESCALER * rate),
            "the rate is not exact"
        );
        assert!(
            trigger_ticks(rate) <= 1 << 16,
            "the period does not fit the timer"
        );
        assert!(
            SCAN_NS / 95 * 100 < 1_000_000_000 / rate,
            "the scan does not fit the period"
        );
        i += 1;
    }
};

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

/// From the end of a transmission's DMA to that of its last character: two characters take 10 µs.
pub const LAST_CHARACTERS: Duration = Duration::from_micros(20);

/// The watchdog resets a board of which a part makes no progress for so long: longer than the slowest flash
/// operation (a page is erased in 22 ms, and a commit may need several), shorter than a user's patience.
pub const WATCHDOG_US: u32 = 1_000_000;
/// How often the watchdog is fed at most.
pub const SUPERVISOR_PERIOD: Duration = Duration::from_millis(100);
/// How often an idle link says that it is alive.
pub const LINK_HEARTBEAT: Duration = Duration::from_millis(100);
/// How often an idle storage says that it is alive.
pub const STORAGE_HEARTBEAT: Duration = Duration::from_millis(100);
/// How long the crystal may take to start, ms: ten times what its data sheet says.
pub const CRYSTAL_START_MS: u32 = 20;
