//! RM0440 chapter 3. Core clock 150 MHz.

mod options;
mod torn;

use tempfile::TempDir;
use virtual_board::injection::Progress;
use virtual_board::memory::ecc::Flaw;
use virtual_board::memory::flash::{FlashFileError, FlashMemory};
use virtual_board::memory::{BANK_SIZE, FLASH_SIZE};
use virtual_board::peripherals::flash::Flash;

const KEYR: u32 = 0x08;
const SR: u32 = 0x10;
const CR: u32 = 0x14;
const OPTR: u32 = 0x20;

const EOP: u32 = 1;
const OPERR: u32 = 1 << 1;
const PROGERR: u32 = 1 << 3;
const PGAERR: u32 = 1 << 5;
const SIZERR: u32 = 1 << 6;
const PGSERR: u32 = 1 << 7;
const BSY: u32 = 1 << 16;
const PG: u32 = 1;
const PER: u32 = 1 << 1;
const BKER: u32 = 1 << 11;
const STRT: u32 = 1 << 16;
const ECCR: u32 = 0x18;
const ECCCIE: u32 = 1 << 24;
const ECCC: u32 = 1 << 30;
const ECCD: u32 = 1 << 31;
const EOPIE: u32 = 1 << 24;
const ERRIE: u32 = 1 << 25;
const LOCK: u32 = 1 << 31;

const PROGRAM: u64 = 12_750; // 85 µs
const PAGE_ERASE: u64 = 3_303_000; // 22.02 ms

struct Bench {
    flash: Flash,
    memory: FlashMemory,
    /// Where its file is, `flash.bin`.
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self {
            flash: Flash::new(crate::noise(), 150e6),
            memory: FlashMemory::open(&folder.path().join("flash.bin")).unwrap(),
            folder,
        }
    }

    fn unlocked() -> Self {
        let mut bench = Self::new();
        bench.flash.write(KEYR, 0x4567_0123, 0).unwrap();
        bench.flash.write(KEYR, 0xCDEF_89AB, 0).unwrap();
        bench
    }

    fn store(&mut self, offset: usize, value: u32, now: u64) {
        self.flash.store(offset, value, 4, &self.memory, now);
    }

    fn advance(&mut self, now: u64) {
        self.flash.advance(now, &mut self.memory).unwrap();
    }

    fn status(&self) -> u32 {
        self.flash.read(SR).unwrap()
    }

    fn watched(&self, bank: usize) -> bool {
        self.flash.watched(bank, &self.memory)
    }

    fn check_read(&mut self, offset: usize) -> bool {
        self.flash.check_read(offset, &self.memory)
    }

    fn program(&mut self, offset: usize, value: u32, now: u64) {
        self.flash.write(CR, PG, now).unwrap();
        self.store(offset, value, now);
        self.store(offset + 4, value, now);
        self.advance(now + PROGRAM);
    }

    /// Another power-on: the files stay, the chip begins anew.
    fn power_on(&mut self) {
        self.memory = FlashMemory::open(&self.folder.path().join("flash.bin")).unwrap();
        self.flash = Flash::new(crate::noise(), 150e6);
    }

    /// What the file holds.
    fn file(&self) -> Vec<u8> {
        std::fs::read(self.folder.path().join("flash.bin")).unwrap()
    }
}

#[test]
fn starts_locked_in_dual_bank_mode() {
    let mut bench = Bench::new();
    assert_eq!(bench.flash.read(CR).unwrap() & LOCK, LOCK);
    assert!(bench.flash.write(CR, PG, 0).is_err());
    assert_eq!(bench.flash.read(CR).unwrap() & PG, 0);
    assert_eq!(bench.flash.read(OPTR).unwrap() & 1 << 22, 1 << 22, "DBANK");
}

#[test]
fn a_wrong_key_is_a_bus_error_and_locks_until_reset() {
    let mut bench = Bench::new();
    bench.flash.write(KEYR, 0x4567_0123, 0).unwrap();
    assert!(!bench.flash.take_bus_error());
    bench.flash.write(KEYR, 0x1234_5678, 0).unwrap();
    assert!(bench.flash.take_bus_error());
    bench.flash.write(KEYR, 0x4567_0123, 0).unwrap();
    bench.flash.write(KEYR, 0xCDEF_89AB, 0).unwrap();
    assert_eq!(bench.flash.read(CR).unwrap() & LOCK, LOCK);
    bench.flash.reset(&mut bench.memory).unwrap();
    bench.flash.write(KEYR, 0x4567_0123, 0).unwrap();
    bench.flash.write(KEYR, 0xCDEF_89AB, 0).unwrap();
    assert_eq!(bench.flash.read(CR).unwrap() & LOCK, 0);
}

#[test]
fn two_words_program_a_double_word_in_85_us_and_reach_the_file() {
    let mut bench = Bench::unlocked();
    bench.flash.write(CR, PG | EOPIE, 0).unwrap();
    bench.store(0x40000, 0x1111_2222, 100);
    assert_eq!(
        bench.status() & BSY,
        0,
        "the first word only fills the latch"
    );
    bench.store(0x40004, 0x3333_4444, 100);
    assert_eq!(bench.status() & BSY, BSY);
    assert!(bench.flash.is_busy(1) && !bench.flash.is_busy(0));
    assert_eq!(bench.flash.next_event(), 100 + PROGRAM);
    assert_eq!(bench.memory.double_word(0x40000), u64::MAX);
    bench.advance(100 + PROGRAM);
    assert_eq!(bench.status(), EOP);
    assert!(bench.flash.interrupt());
    assert_eq!(bench.memory.double_word(0x40000), 0x3333_4444_1111_2222);
    assert_eq!(
        bench.file()[0x40000..0x40008],
        0x3333_4444_1111_2222_u64.to_le_bytes()
    );
    bench.flash.write(SR, EOP, 0).unwrap();
    assert!(!bench.flash.interrupt());
}

#[test]
fn end_and_error_are_flagged_only_if_enabled() {
    let mut bench = Bench::unlocked();
    bench.flash.write(CR, PG, 0).unwrap();
    bench.store(0, 0, 0);
    bench.store(4, 0, 0);
    bench.advance(PROGRAM);
    assert_eq!(bench.status() & EOP, 0);
    bench.store(8, 0, 20_000);
    bench.store(16, 0, 20_000);
    assert_eq!(bench.status() & (PGAERR | OPERR), PGAERR);
    bench.flash.write(SR, PGAERR, 0).unwrap();
    bench.flash.write(CR, PG | ERRIE, 0).unwrap();
    bench.store(12, 0, 20_000);
    assert_eq!(bench.status() & (PGAERR | OPERR), PGAERR | OPERR);
    assert!(bench.flash.interrupt());
}

#[test]
fn a_double_word_is_written_once_but_may_be_zeroed() {
    let mut bench = Bench::unlocked();
    let program = |bench: &mut Bench, value: u32, now: u64| {
        bench.flash.write(CR, PG, now).unwrap();
        bench.store(0x800, value, now);
        bench.store(0x804, value, now);
        bench.advance(now + PROGRAM);
    };
    program(&mut bench, 0xFFFF_0000, 0);
    program(&mut bench, 0xFF00_0000, 100_000);
    assert_eq!(bench.status() & PROGERR, PROGERR);
    assert_eq!(bench.memory.double_word(0x800), 0xFFFF_0000_FFFF_0000);
    program(&mut bench, 0, 200_000);
    assert_eq!(
        bench.status() & PGSERR,
        PGSERR,
        "an error must be cleared first"
    );
    bench.flash.write(SR, PROGERR | PGSERR, 0).unwrap();
    program(&mut bench, 0, 300_000);
    assert_eq!(bench.memory.double_word(0x800), 0);
}

#[test]
fn stores_must_be_words_and_announced() {
    let mut bench = Bench::unlocked();
    bench.store(0, 1, 0);
    assert_eq!(bench.status() & PGSERR, PGSERR, "PG is not set");
    bench.flash.write(SR, PGSERR, 0).unwrap();
    bench.flash.write(CR, PG, 0).unwrap();
    bench.flash.store(0, 1, 2, &bench.memory, 0);
    assert_eq!(bench.status() & SIZERR, SIZERR);
}

#[test]
fn a_page_of_bank_2_is_erased_in_22_ms_and_no_other() {
    let mut bench = Bench::unlocked();
    for page in [BANK_SIZE + 2 * 2048, BANK_SIZE + 3 * 2048, 3 * 2048] {
        bench.memory.write(page, &[0; 2048]).unwrap();
    }
    bench
        .flash
        .write(CR, PER | 3 << 3 | BKER | STRT | EOPIE, 0)
        .unwrap();
    assert!(bench.flash.is_busy(1) && !bench.flash.is_busy(0));
    assert_eq!(bench.flash.next_event(), PAGE_ERASE);
    bench.advance(PAGE_ERASE - 1);
    assert_eq!(bench.status() & BSY, BSY);
    assert!(bench.watched(1) && !bench.watched(0));
    bench.advance(PAGE_ERASE);
    assert_eq!(bench.status(), EOP);
    assert_eq!(bench.flash.read(CR).unwrap() & STRT, 0);
    let file = bench.file();
    assert!(
        file[BANK_SIZE + 3 * 2048..BANK_SIZE + 4 * 2048]
            .iter()
            .all(|byte| *byte == 0xFF)
    );
    assert!(
        file[BANK_SIZE + 2 * 2048..BANK_SIZE + 3 * 2048]
            .iter()
            .all(|byte| *byte == 0)
    );
    assert!(file[3 * 2048..4 * 2048].iter().all(|byte| *byte == 0));
}

#[test]
fn mass_erase_takes_a_bank() {
    let mut bench = Bench::unlocked();
    bench.memory.write(8, &[0; 8]).unwrap();
    bench.memory.write(BANK_SIZE + 8, &[0; 8]).unwrap();
    bench.flash.write(CR, 1 << 15 | STRT, 0).unwrap();
    bench.advance(bench.flash.next_event());
    assert_eq!(bench.memory.double_word(BANK_SIZE + 8), u64::MAX);
    assert_eq!(bench.memory.double_word(8), 0);
}

#[test]
fn programming_and_erasing_at_once_is_a_sequence_error() {
    let mut bench = Bench::unlocked();
    bench.flash.write(CR, PG | PER | STRT, 0).unwrap();
    assert_eq!(bench.status() & (PGSERR | BSY), PGSERR);
    assert_eq!(bench.flash.read(CR).unwrap() & STRT, 0);
}

#[test]
fn a_file_of_another_size_is_refused_and_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flash.bin");
    std::fs::write(&path, [1, 2, 3]).unwrap();
    let error = FlashMemory::open(&path).unwrap_err();
    assert!(matches!(error, FlashFileError::Size { found: 3, .. }));
    assert!(
        error.to_string().contains(&FLASH_SIZE.to_string()),
        "{error}"
    );
    assert_eq!(std::fs::read(&path).unwrap(), [1, 2, 3]);
}
