//! The reader of the firmware's log.

use virtual_board::firmware::log::FirmwareLog;
use virtual_board::memory::RAM_SIZE;
use virtual_board::memory::block::Block;

/// Where the control block is, and in it offsets of the write and read positions and the flags of the first channel.
const CONTROL: usize = 0x40;
const WRITE: usize = CONTROL + 36;
const READ: usize = CONTROL + 40;
const FLAGS: usize = CONTROL + 44;

#[test]
fn a_probe_that_stops_reading_leaves_the_channel_blocking_and_full() {
    let mut ram = Block::new(RAM_SIZE);
    let mut put = |offset: usize, word: u32| assert!(ram.write(offset, &word.to_le_bytes()));
    put(CONTROL + 28, 0x2000_0100);
    put(CONTROL + 32, 64);
    put(WRITE, 5);
    put(READ, 0);
    put(FLAGS, 1);
    assert!(ram.write(CONTROL, b"SEGGER RTT"));
    let mut log = FirmwareLog::new(&[], Some(0x2000_0000 + CONTROL as u32));
    log.poll(&mut ram, 0.0);
    assert_eq!((ram.word(READ), ram.word(FLAGS)), (Some(5), Some(1)));
    log.stop_reading(&mut ram);
    assert!(ram.write(WRITE, &9u32.to_le_bytes()));
    log.poll(&mut ram, 0.0);
    assert_eq!((ram.word(READ), ram.word(FLAGS)), (Some(5), Some(2)));
}
