//! The program from outside: its error messages, and the link in lockstep.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_virtual-board");

/// A folder of its own for a test, with this program as `firmware`.
fn folder_with(halves: &[u16]) -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let [firmware, flash] = ["firmware", "flash.bin"].map(|name| folder.path().join(name));
    std::fs::write(&firmware, arm(halves)).unwrap();
    (folder, firmware, flash)
}

/// A 32-bit ELF file with one segment.
fn elf(machine: u16, address: u32, code: &[u8]) -> Vec<u8> {
    let mut file = vec![0x7F, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    file.extend([2, 0]);
    file.extend(machine.to_le_bytes());
    for word in [1, address, 52, 0, 0x0500_0400] {
        file.extend(u32::to_le_bytes(word));
    }
    for half in [52, 32, 1, 40, 0, 0] {
        file.extend(u16::to_le_bytes(half));
    }
    for word in [
        1,
        84,
        address,
        address,
        code.len() as u32,
        code.len() as u32,
        5,
        4,
    ] {
        file.extend(u32::to_le_bytes(word));
    }
    file.extend(code);
    file
}

/// Vector table and code: initial stack pointer, reset vector, HardFault vector, and half-words from 0x0800_0040 on.
fn image(halves: &[u16]) -> Vec<u8> {
    let mut image = vec![0; 0x40];
    image[0..4].copy_from_slice(&0x2000_8000_u32.to_le_bytes());
    image[4..8].copy_from_slice(&0x0800_0041_u32.to_le_bytes());
    image[12..16].copy_from_slice(&0x0800_0041_u32.to_le_bytes());
    image.extend(halves.iter().flat_map(|half| half.to_le_bytes()));
    image
}

fn arm(halves: &[u16]) -> Vec<u8> {
    elf(40, 0x0800_0000, &image(halves))
}

fn command(elf: &Path, flash: &Path) -> Command {
    let mut command = Command::new(PROGRAM);
    command.arg("--elf").arg(elf).arg("--flash").arg(flash);
    command
}

fn refused(elf: &Path, flash: &Path, extra: &[&str]) -> String {
    let Output {
        status,
        stdout,
        stderr,
    } = command(elf, flash)
        .args(["--link", "lockstep:127.0.0.1:0"])
        .args(extra)
        .output()
        .unwrap();
    assert!(!status.success());
    assert!(stdout.is_empty(), "nothing is promised on stdout");
    String::from_utf8(stderr).unwrap()
}

/// A running board and its lockstep connection.
struct Board {
    child: Child,
    stream: TcpStream,
}

impl Board {
    fn start(elf: &Path, flash: &Path) -> Self {
        let mut child = command(elf, flash)
            .args(["--link", "lockstep:127.0.0.1:0"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap())
            .read_line(&mut line)
            .unwrap();
        let address = line
            .trim()
            .strip_prefix("{\"link\":\"lockstep:")
            .and_then(|rest| rest.strip_suffix("\"}"));
        let stream = TcpStream::connect(address.unwrap()).unwrap();
        Self { child, stream }
    }

    fn exchange(&mut self, run_us: u32, bytes: &[u8]) -> (u64, Vec<u8>) {
        self.stream.write_all(&run_us.to_le_bytes()).unwrap();
        self.stream
            .write_all(&(bytes.len() as u32).to_le_bytes())
            .unwrap();
        self.stream.write_all(bytes).unwrap();
        let mut head = [0; 12];
        self.stream.read_exact(&mut head).unwrap();
        let now_us = u64::from_le_bytes(head[..8].try_into().unwrap());
        let mut sent = vec![0; u32::from_le_bytes(head[8..].try_into().unwrap()) as usize];
        self.stream.read_exact(&mut sent).unwrap();
        (now_us, sent)
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn files_that_are_no_firmware_are_refused_with_the_reason() {
    let (folder, file, flash) = folder_with(&[]);
    let say = |content: &[u8]| {
        std::fs::write(&file, content).unwrap();
        refused(&file, &flash, &[])
    };
    assert!(say(b"not an ELF file").contains("not a 32-bit ELF file"));
    assert!(say(&elf(62, 0x0800_0000, &[0; 8])).contains("ELF machine 62"));
    assert!(say(&elf(40, 0x2000_0000, &[0; 8])).contains("0x20000000"));
    assert!(say(&elf(40, 0x0800_0000, &[])).contains("nothing to load"));
    assert!(refused(&folder.path().join("nothing"), &flash, &[]).contains("No such file"));
    assert!(
        !flash.exists(),
        "nothing is written before the firmware is known to be good"
    );
}

#[test]
fn an_option_register_that_does_not_exist_is_refused_with_those_that_do() {
    let (_folder, firmware, flash) = folder_with(&[0xE7FE]);
    for wrong in ["DBANK=0", "OPTR=1", "OPTR=0xg", "SEC1R=0x0"] {
        let said = refused(&firmware, &flash, &["--option", wrong]);
        assert!(said.contains("OPTR, WRP1AR, WRP1BR"), "{wrong}: {said}");
    }
}

#[test]
fn a_flash_file_of_another_size_is_refused() {
    let (_folder, firmware, flash) = folder_with(&[0xE7FE]);
    std::fs::write(&flash, [0; 100]).unwrap();
    let said = refused(&firmware, &flash, &[]);
    assert!(
        said.contains("100 bytes") && said.contains("524288"),
        "{said}"
    );
}

#[test]
fn a_twin_that_is_not_there_is_named() {
    let (_folder, firmware, flash) = folder_with(&[0xE7FE]);
    let said = refused(&firmware, &flash, &["--pins", "tcp:127.0.0.1:1"]);
    assert!(said.contains("no twin at 127.0.0.1:1"), "{said}");
    let said = refused(&firmware, &flash, &["--pins", "127.0.0.1:1"]);
    assert!(said.contains("expected tcp:HOST:PORT"), "{said}");
}

#[test]
fn firmware_that_faults_for_good_ends_the_program_with_the_place() {
    let (_folder, firmware, flash) = folder_with(&[0xBF00, 0xDE00]);
    let mut child = command(&firmware, &flash)
        .args(["--link", "tcp:127.0.0.1:0"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    assert!(!child.wait().unwrap().success());
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(
        said.contains("faulted for good") && said.contains("0x08000042"),
        "{said}"
    );
}

#[test]
fn time_passes_in_lockstep_only_as_asked_and_goes_on_with_the_next_host() {
    let (_folder, firmware, flash) = folder_with(&[0xBF20, 0xE7FD]); // wfe; b back
    let mut board = Board::start(&firmware, &flash);
    assert_eq!(board.exchange(10_000, b"nobody listens"), (10_000, vec![]));
    assert_eq!(board.exchange(500, &[]), (10_500, vec![]));
    let address = board.stream.peer_addr().unwrap();
    board.stream = TcpStream::connect(address).unwrap();
    assert_eq!(board.exchange(1_000_000, &[]), (1_010_500, vec![]));
}

#[test]
fn programming_leaves_the_rest_of_the_flash_alone() {
    let (_folder, firmware, flash) = folder_with(&[0xE7FE]);
    let mut content = vec![0xFF; 512 * 1024];
    content[0x40000..0x40004].copy_from_slice(b"keep");
    content[0x1000] = 7;
    std::fs::write(&flash, &content).unwrap();
    let mut board = Board::start(&firmware, &flash);
    board.exchange(100, &[]);
    let now = std::fs::read(&flash).unwrap();
    assert_eq!(now[0x40..0x42], [0xFE, 0xE7]);
    assert_eq!((&now[0x40000..0x40004], now[0x1000]), (&b"keep"[..], 7));
}
