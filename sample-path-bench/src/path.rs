//! The portable sample path, driven through every size of block with input of every kind.

use core::hint::black_box;

use hexsense::channel::{INERTIAL, JACKS};
use hexsense::harmonics::{Analyser, Drive, increment, solve};
use hexsense::sampling::{BlockSize, BlockSums, Calibrator, Prepared, Values, add_up};
use hexsense::store::TriadCoefficients;
use static_cell::ConstStaticCell;

use crate::signal;

/// Blocks of each size.
const BLOCKS: usize = 10_000;
/// Blocks between one drive and the next, with another frequency, phase and coefficients.
const BLOCKS_OF_A_DRIVE: usize = 100;

/// Pseudo-random bits (xorshift, Marsaglia 2003).
struct Random(u32);

impl Random {
    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// Random, saturated, alternating or zero counts.
    fn fill(&mut self, kind: usize, counts: &mut [u16]) {
        for (index, count) in counts.iter_mut().enumerate() {
            *count = match kind % 4 {
                0 => self.next() as u16,
                1 => u16::MAX,
                2 if index % 2 == 0 => u16::MAX,
                _ => 0,
            };
        }
    }

    /// Coefficients of any sign and size that sensors have.
    fn coefficients(&mut self) -> Prepared {
        let triads = [(); 3].map(|()| TriadCoefficients {
            offset: [(); 3].map(|()| (self.next() >> 16) as f32),
            matrix: [[(); 3]; 3].map(|row| row.map(|()| self.next() as i32 as f32 * 1e-13)),
            offset_uncertainty: [0.0; 3],
            matrix_uncertainty: [[0.0; 3]; 3],
            delay_s: 0.0,
        });
        Calibrator::of_triads(&triads).at_supply(1.0 + self.next() as i32 as f32 * 1e-12)
    }
}

/// One size of block under a name that can be counted: calibrated values with sums of nine channels, and sums alone of
/// nine and of six. The number keeps equal functions from being folded into one; it costs three instructions.
macro_rules! sized {
    ($scans:literal, $calibrate:ident, $nine:ident, $six:ident) => {
        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $calibrate(
            prepared: &Prepared,
            scans: &[[u16; INERTIAL]],
            values: &mut [Values],
            sums: &mut [u32; INERTIAL],
        ) {
            black_box($scans);
            prepared.block(scans, values, sums);
        }

        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $nine(scans: &[[u16; INERTIAL]], sums: &mut [u32; INERTIAL]) {
            black_box($scans);
            add_up(scans, sums);
        }

        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $six(scans: &[[u16; JACKS]], sums: &mut [u32; JACKS]) {
            black_box($scans);
            add_up(scans, sums);
        }
    };
}

sized!(1, calibrate_1, nine_1, six_1);
sized!(4, calibrate_4, nine_4, six_4);
sized!(8, calibrate_8, nine_8, six_8);
sized!(16, calibrate_16, nine_16, six_16);
sized!(32, calibrate_32, nine_32, six_32);

type Calibrate = fn(&Prepared, &[[u16; INERTIAL]], &mut [Values], &mut [u32; INERTIAL]);
type Add<const N: usize> = fn(&[[u16; N]], &mut [u32; N]);

fn of_size(size: BlockSize) -> (Calibrate, Add<INERTIAL>, Add<JACKS>) {
    match size {
        BlockSize::One => (calibrate_1, nine_1, six_1),
        BlockSize::Four => (calibrate_4, nine_4, six_4),
        BlockSize::Eight => (calibrate_8, nine_8, six_8),
        BlockSize::Sixteen => (calibrate_16, nine_16, six_16),
        BlockSize::ThirtyTwo => (calibrate_32, nine_32, six_32),
    }
}

struct Memory {
    inertial: [[u16; INERTIAL]; BlockSize::MOST],
    jacks: [[u16; JACKS]; BlockSize::MOST],
    values: [Values; BlockSize::MOST],
    analyser: Analyser,
}

/// Drives every size of block, then estimates the signal.
pub fn run() {
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory {
        inertial: [[0; INERTIAL]; BlockSize::MOST],
        jacks: [[0; JACKS]; BlockSize::MOST],
        values: [[0.0; INERTIAL]; BlockSize::MOST],
        analyser: Analyser::new(),
    });
    // Its address must not be known, or the sums are found by longer instructions than on the board.
    let memory = black_box(MEMORY.take());
    let mut random = Random(0x2545_F491);
    defmt::println!("analyser bytes {}", size_of::<Analyser>());
    for size in BlockSize::ALL {
        exercise(memory, &mut random, size);
    }
    estimate(memory);
}

fn exercise(memory: &mut Memory, random: &mut Random, size: BlockSize) {
    let (calibrate, nine, six) = of_size(size);
    let scans = size.scans();
    let mut prepared = Prepared::NONE;
    for block in 0..BLOCKS {
        if block % BLOCKS_OF_A_DRIVE == 0 {
            prepared = random.coefficients();
            memory.analyser.start(Drive {
                increment: (u64::from(random.next()) << 32) >> (4 + scans.ilog2()),
                block: size,
                settle_blocks: 0,
                blocks: 1 << (random.next() % 15 + 7),
            });
        }
        let inertial = &mut memory.inertial[..scans];
        let jacks = &mut memory.jacks[..scans];
        random.fill(block, inertial.as_flattened_mut());
        random.fill(block / 4, jacks.as_flattened_mut());
        let mut sums = BlockSums {
            first_scan: (block * scans) as u64,
            inertial: [0; INERTIAL],
            jacks: [0; JACKS],
        };
        nine(inertial, &mut sums.inertial);
        calibrate(&prepared, inertial, &mut memory.values, &mut sums.inertial);
        six(jacks, &mut sums.jacks);
        memory.analyser.take(&sums);
        black_box(&memory.values);
    }
}

fn estimate(memory: &mut Memory) {
    let size = BlockSize::Sixteen;
    let drive = Drive {
        increment: increment(signal::FREQUENCY_HZ, signal::RATE_HZ).unwrap_or(0),
        block: size,
        settle_blocks: 0,
        blocks: (signal::SCANS / size.scans()) as u32,
    };
    memory.analyser.start(drive);
    for first in (0..signal::SCANS).step_by(size.scans()) {
        let mut sums = BlockSums {
            first_scan: first as u64,
            inertial: [0; INERTIAL],
            jacks: [0; JACKS],
        };
        for (index, scan) in memory.inertial[..size.scans()].iter_mut().enumerate() {
            *scan = [signal::count(first + index); INERTIAL];
        }
        add_up(&memory.inertial[..size.scans()], &mut sums.inertial);
        memory.analyser.take(&sums);
    }
    let sums = memory.analyser.report(0).map(|(_, _, sums)| sums);
    let amplitude = sums
        .and_then(|sums| solve(drive, &sums))
        .map_or(f64::NAN, |fit| fit.first().amplitude());
    defmt::println!("amplitude hexsense {}", amplitude.to_bits());
}
