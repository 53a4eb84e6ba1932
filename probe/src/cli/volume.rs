//! Volumes of the log: their export, the check of an export, and the beginning of the next.

use std::path::Path;

use anyhow::{anyhow, ensure};
use hexsense_client::Client;
use hexsense_core::wire::change::Key;
use hexsense_core::wire::log::Volume;

use super::confirm::confirm;
use crate::log_file::{LogFile, volume_flaws};
use crate::terminal::{say, tell};
use crate::{files, key_file};

/// Writes the log's volume into a file, signed by the board.
pub fn export(client: &mut Client, path: &Path, key: Option<&Key>) -> anyhow::Result<()> {
    let file = path.display();
    ensure!(
        !path.exists(),
        "{file}: is there already, and exports are never overwritten; name another file"
    );
    let mut nonce = [0; 32];
    getrandom::fill(&mut nonce)
        .map_err(|reason| anyhow!("the system gives no random numbers: {reason}"))?;
    let board = client.identity()?.board;
    let (volume, mac) = client.log_proof(nonce)?;
    let mut entries = client.log(1)?;
    entries.retain(|entry| entry.counter <= volume.last);
    let log = LogFile {
        board,
        nonce,
        volume,
        mac,
        entries,
    };
    let flaws = volume_flaws(&log.entries, &volume);
    if let Some(key) = key {
        ensure!(
            log.is_signed(key),
            "the log was not signed with the key in this file; nothing was written"
        );
    }
    log.save(path)?;
    say!(
        "written: {file}, {} entries, changes {} to {} of board {}",
        log.entries.len(),
        volume.first,
        volume.last,
        files::hex(&board)
    )?;
    for flaw in flaws {
        say!("{flaw}")?;
    }
    Ok(())
}

/// Begins the next volume.
pub fn begin(client: &mut Client, key: &Key, is_sure: bool) -> anyhow::Result<()> {
    let log = client.log(1)?;
    let last = log
        .last()
        .ok_or_else(|| anyhow!("the log is empty; there is nothing to close"))?;
    if !is_sure {
        tell!(
            "the board will overwrite the {} entries up to change {} in time; --export FILE keeps them",
            log.len(),
            last.counter
        );
        confirm(
            "Begin a new volume without an export?",
            "the volume stays open",
        )?;
    }
    client.new_volume(key, last.counter)?;
    say!(
        "change {} begins a new volume of the log and carries the hash of change {}",
        last.counter + 1,
        last.counter
    )?;
    Ok(())
}

/// Checks a file, and says what that proves.
pub fn check(path: &Path, key: Option<&Path>) -> anyhow::Result<()> {
    let log = LogFile::load(path)?;
    let file = path.display();
    let flaws = volume_flaws(&log.entries, &log.volume);
    ensure!(flaws.is_empty(), "{file}: {}", flaws.join("; "));
    let Volume { first, last, .. } = log.volume;
    say!(
        "{file}: board {}, changes {first} to {last}; no entry is missing or altered",
        files::hex(&log.board)
    )?;
    if let Some(first) = log.entries.first().filter(|entry| entry.counter > 1) {
        say!(
            "it continues the volume whose head is {}",
            files::hex(&first.chain)
        )?;
    }
    say!("its head is {}", files::hex(&log.volume.head))?;
    match key {
        None => say!(
            "not proven without the key: that the board wrote it. Whoever makes up all entries can compute all hashes; \
             give --key FILE"
        )?,
        Some(key) => {
            ensure!(
                log.is_signed(&key_file::load(key)?),
                "{file}: the signature is NOT that of this board with this key: another key was given, or the file is forged"
            );
            say!("proven with the key: the board signed it, or somebody else who has the key")?;
        }
    }
    Ok(())
}
