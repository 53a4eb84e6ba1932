//! The portable sample path, driven through every size of block with input of every kind.

use core::hint::black_box;

use hexsense_core::channel::{INERTIAL, JACKS, Ratiometric};
use hexsense_core::harmonics::{Analyser, Drive, Step, increment, solve};
use hexsense_core::records::TriadCoefficients;
use hexsense_core::sampling::{BlockSize, BlockSums, Calibrator, Prepared, Values, add_up};
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
        Calibrator::of_triads(&triads, Ratiometric::NONE)
            .at_supply(1.0 + self.next() as i32 as f32 * 1e-12)
    }

    /// A drive of any frequency, with any window; of the blocks that are driven with it the first settle, and where the
    /// window is short the last find it complete.
    fn drive(&mut self, block: BlockSize) -> Drive {
        Drive {
            increment: (u64::from(self.next()) << 32) >> (4 + block.scans().ilog2()),
            block,
            settle_blocks: self.next() % 50,
            blocks: 1 << (self.next() % 18 + 4),
        }
    }
}

/// One size of block under names that can be counted: the path of nine channels, its sums alone, and the path with the
/// sums of the jacks.
macro_rules! sized {
    ($scans:literal, $path:ident, $sums:ident, $path_with_jacks:ident) => {
        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $path(
            prepared: &Prepared,
            scans: &[[u16; INERTIAL]; $scans],
            values: &mut [Values; $scans],
            state: &mut State,
        ) {
            prepared.block(scans, values, &mut state.sums.inertial);
            state.take_inertial();
        }

        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $sums(scans: &[[u16; INERTIAL]; $scans], state: &mut State) {
            add_up(scans, &mut state.sums.inertial);
            state.take_inertial();
        }

        #[unsafe(no_mangle)]
        #[inline(never)]
        fn $path_with_jacks(
            prepared: &Prepared,
            scans: &[[u16; INERTIAL]; $scans],
            jacks: &[[u16; JACKS]; $scans],
            values: &mut [Values; $scans],
            state: &mut State,
        ) {
            prepared.block(scans, values, &mut state.sums.inertial);
            add_up(jacks, &mut state.sums.jacks);
            state.take_inertial();
            state.analyser.take_jacks(&state.step, &state.sums.jacks);
        }
    };
}

sized!(1, path_1, sums_1, path_with_jacks_1);
sized!(4, path_4, sums_4, path_with_jacks_4);
sized!(8, path_8, sums_8, path_with_jacks_8);
sized!(16, path_16, sums_16, path_with_jacks_16);
sized!(32, path_32, sums_32, path_with_jacks_32);

type Path<const N: usize> = fn(&Prepared, &[[u16; INERTIAL]; N], &mut [Values; N], &mut State);
type Sums<const N: usize> = fn(&[[u16; INERTIAL]; N], &mut State);
type PathWithJacks<const N: usize> =
    fn(&Prepared, &[[u16; INERTIAL]; N], &[[u16; JACKS]; N], &mut [Values; N], &mut State);

/// What one analyser needs.
struct State {
    sums: BlockSums,
    analyser: Analyser,
    step: Step,
}

impl State {
    const NEW: Self = Self {
        sums: BlockSums {
            first_scan: 0,
            inertial: [0; INERTIAL],
            jacks: [0; JACKS],
        },
        analyser: Analyser::new(),
        step: Step::NONE,
    };

    #[inline(always)]
    fn take_inertial(&mut self) {
        let Self {
            sums,
            analyser,
            step,
        } = self;
        analyser.take_inertial(sums.first_scan, &sums.inertial, step);
    }
}

struct Memory {
    inertial: [[u16; INERTIAL]; BlockSize::MAX_SCANS],
    jacks: [[u16; JACKS]; BlockSize::MAX_SCANS],
    values: [Values; BlockSize::MAX_SCANS],
    /// For the path, the sums and the path with jacks.
    states: [State; 3],
}

/// Drives every size of block, then estimates the signal.
pub fn run() {
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory {
        inertial: [[0; INERTIAL]; BlockSize::MAX_SCANS],
        jacks: [[0; JACKS]; BlockSize::MAX_SCANS],
        values: [[0.0; INERTIAL]; BlockSize::MAX_SCANS],
        states: [State::NEW; 3],
    });
    // Its address must not be known, or the sums are found by longer instructions than on the board.
    let memory = black_box(MEMORY.take());
    let mut random = Random(0x2545_F491);
    defmt::println!("analyser bytes {}", size_of::<Analyser>());
    exercise(memory, &mut random, path_1, sums_1, path_with_jacks_1);
    exercise(memory, &mut random, path_4, sums_4, path_with_jacks_4);
    exercise(memory, &mut random, path_8, sums_8, path_with_jacks_8);
    exercise(memory, &mut random, path_16, sums_16, path_with_jacks_16);
    exercise(memory, &mut random, path_32, sums_32, path_with_jacks_32);
    estimate(memory);
}

fn exercise<const N: usize>(
    memory: &mut Memory,
    random: &mut Random,
    path: Path<N>,
    sums: Sums<N>,
    path_with_jacks: PathWithJacks<N>,
) {
    let (Some(size), Some(inertial), Some(jacks), Some(values)) = (
        BlockSize::of_scans(N),
        memory.inertial.first_chunk_mut(),
        memory.jacks.first_chunk_mut(),
        memory.values.first_chunk_mut(),
    ) else {
        return;
    };
    let mut prepared = Prepared::NONE;
    for block in 0..BLOCKS {
        if block % BLOCKS_OF_A_DRIVE == 0 {
            prepared = random.coefficients();
            let drive = random.drive(size);
            for state in &mut memory.states {
                state.analyser.start(drive);
            }
        }
        random.fill(block, inertial.as_flattened_mut());
        random.fill(block / 4, jacks.as_flattened_mut());
        for state in &mut memory.states {
            state.sums.first_scan = (block * N) as u64;
        }
        let [one, two, three] = &mut memory.states;
        path(&prepared, inertial, values, one);
        sums(inertial, two);
        path_with_jacks(&prepared, inertial, jacks, values, three);
        black_box(&values);
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
    let [State { analyser, .. }, ..] = &mut memory.states;
    analyser.start(drive);
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
        analyser.take(&sums);
    }
    let sums = analyser.report(0).map(|(_, _, sums)| sums);
    let amplitude = sums
        .and_then(|sums| solve(&drive, &sums))
        .map_or(f64::NAN, |fit| fit.first().amplitude());
    defmt::println!("amplitude hexsense {}", amplitude.to_bits());
}
