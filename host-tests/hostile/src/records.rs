//! Bytes that may be a coefficient set, and flash with anything in it.
//!
//! A decoded set is the same after it is encoded again, and is usable. A board starts with any flash, or gives the
//! reason why not; with a sound log it then takes a key and a good upload.

use std::cell::RefCell;

use crc::{CRC_32_ISO_HDLC, Crc};
use embassy_futures::block_on;
use embedded_storage_async::nor_flash::NorFlash;
use hexsense_core::channel::CHANNELS;
use hexsense_core::facts::FlashLayout;
use hexsense_core::live_pose::{JackBlock, Tracker};
use hexsense_core::records::key::{KeyPages, StoredKey};
use hexsense_core::records::log::{End, Log, Reason};
use hexsense_core::records::{Archive, BuildId, CoefficientSet, Entry, MAX_ENCODED, SetId};
use hexsense_core::sampling::Calibrator;
use hexsense_core::wire::change::{Act, Key};
use hexsense_core::wire::{Refusal, Response};

use crate::bases::{BASES, CONTENTS, GOOD};
use crate::input::Input;
use crate::key_holder::{KEYS, KeyHolder, PAGES, Shared, id};
use crate::nor_flash::{Nor, PAGE, layout};
use crate::sets::BOARD;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
/// Most changes of flash in an attack.
const CHANGES: usize = 8;

/// The first byte chooses the kind of the others.
///
/// # Panics
/// When a promise is broken.
pub fn run(data: &[u8]) {
    let mut input = Input(data);
    match input.byte() % 4 {
        0 => set(input.0, 0),
        1 => set(&sealed(input.0), 0),
        2 => {
            let counts = input.short();
            let mut body = body();
            changed(&mut body, &mut input);
            set(&sealed(&body), counts);
        }
        _ => flash(&mut input),
    }
}

/// A set as postcard, without its checksum.
fn body() -> Vec<u8> {
    let mut body = CONTENTS[0].clone();
    body.truncate(body.len() - 4);
    body
}

/// Adds a checksum that matches.
fn sealed(body: &[u8]) -> Vec<u8> {
    [body, &CHECKSUM.checksum(body).to_le_bytes()].concat()
}

/// Overwrites some of the bytes.
fn changed(bytes: &mut [u8], input: &mut Input) {
    for _ in 0..CHANGES {
        let place = usize::from(input.short()) % bytes.len();
        let length = usize::from(input.byte() % 16);
        let new = input.bytes(length.min(bytes.len() - place));
        bytes[place..place + new.len()].copy_from_slice(new);
    }
}

/// Bytes that may be a set; one that decodes is used, on scans of these counts.
fn set(bytes: &[u8], counts: u16) {
    let set = match CoefficientSet::decode(bytes) {
        Ok(set) => set,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let mut buffer = [0; MAX_ENCODED];
    let encoded = set.encode(&mut buffer).expect("it fits");
    assert!(encoded.len() <= bytes.len());
    assert_eq!(CoefficientSet::decode(encoded).as_ref(), Ok(&set));
    let scan = [counts; CHANNELS];
    let _ = Calibrator::new(&set).apply(&scan, 1.0);
    let mut tracker =
        Tracker::<f32>::new(&set.base, &set.jacks, set.ratiometric).expect("it was checked");
    let block = JackBlock::new(0, 1.0, &[scan]).expect("a block of one");
    for _ in 0..2 {
        let _ = tracker.next(&block);
    }
}

/// Flash after some changes: raw bytes, or well-formed records with anything in them.
fn flash(input: &mut Input) {
    let base = usize::from(input.byte()) % LOGGED.len();
    let nor = RefCell::new(BASES[base].clone());
    let (mut end, mut is_sound) = (End::default(), true);
    for _ in 0..CHANGES {
        if input.is_empty() {
            break;
        }
        match input.byte() % 5 {
            0 => is_sound &= raw(&nor, input),
            1 => {
                let entry = entry(input);
                let log = LOG_OF_NOR;
                let _ = block_on(Log::new(Shared(&nor), log).append(&mut end, &entry));
                is_sound = false;
            }
            2 => {
                let key = StoredKey {
                    counter: input.short().into(),
                    unix_s: 0,
                    key: input.pick(&[&KEYS[0], &KEYS[1]]).clone(),
                };
                let page = input.byte() % 2;
                let _ = block_on(keys(&nor).store(page, &key));
            }
            3 => {
                let content = &CONTENTS[usize::from(input.byte()) % GOOD];
                // A board stores sets by uploads only, each with the next counter.
                let entry = Entry {
                    counter: u32::from(input.byte()) % (LOGGED[base] + 2),
                    reason: Reason::Upload,
                    id: Some(id(content)),
                    reset: 0,
                    page: 0,
                    ..entry(input)
                };
                let slot = input.byte() % 8;
                let mut archive = Archive::new(Shared(&nor), FlashLayout::ARCHIVE);
                let _ = block_on(archive.append(&entry, content, Some(slot), &BOARD));
            }
            _ => {
                let page = (usize::from(input.byte()) % PAGES * PAGE) as u32;
                let _ = block_on(Shared(&nor).erase(page, page + PAGE as u32));
                is_sound &= page < LOG_OF_NOR.start;
            }
        }
    }
    started(&nor, is_sound);
}

/// Entries in the logs of the bases.
const LOGGED: [u32; 4] = [0, 1, 2, 4];
/// The log in a memory of so many pages.
const LOG_OF_NOR: std::ops::Range<u32> = layout(PAGES).log();

/// Overwrites some bytes, as no flash could; returns whether the log is unchanged.
fn raw(nor: &RefCell<Nor>, input: &mut Input) -> bool {
    let at = usize::from(input.short());
    let length = usize::from(input.byte());
    let bytes = input.bytes(length);
    let mut nor = nor.borrow_mut();
    let place = at % (PAGES * PAGE - bytes.len());
    nor.overwrite(place, bytes);
    place + bytes.len() <= LOG_OF_NOR.start as usize
}

fn entry(input: &mut Input) -> Entry {
    let reasons = [
        Reason::Upload,
        Reason::Rollback,
        Reason::FactoryReset,
        Reason::Provision,
        Reason::Fallback,
        Reason::FirmwareChange,
        Reason::NewVolume,
    ];
    let named = |input: &mut Input| -> Option<SetId> {
        let pick = input.byte();
        let known = CONTENTS.get(usize::from(pick)).map(|content| id(content));
        known.or((pick < 128).then_some(SetId([pick; 8])))
    };
    let counter = match input.short() {
        last @ 0xFF00.. => u32::MAX - u32::from(last & 0xFF),
        counter => counter.into(),
    };
    Entry {
        counter,
        reason: input.pick(&reasons),
        unix_s: 0,
        id: named(input),
        previous: named(input),
        build: BuildId([input.byte(); 8]),
        chain: [input.byte(); 16],
        reset: input.short().into(),
        page: input.short(),
    }
}

/// Starts a board with this flash; with a sound log it must do its work.
fn started(nor: &RefCell<Nor>, is_sound: bool) {
    let (key_holder, first) = KeyHolder::start(Shared(nor));
    let (is_provisioned, active) = (key_holder.storage.is_provisioned(), key_holder.active());
    drop(key_holder);
    let (mut key_holder, second) = KeyHolder::start(Shared(nor));
    if first.is_ok() && second.is_ok() && is_sound {
        assert_eq!(key_holder.active(), active, "a second start finds the same");
    }
    assert!(!is_sound || second.is_ok(), "{second:?}");
    if key_holder.storage.is_key_damaged() {
        return takes_no_change(nor, &mut key_holder);
    }
    let found = keys(nor).load().unwrap();
    let key: Key = found
        .into_iter()
        .flatten()
        .next()
        .map_or(KEYS[0].clone(), |kept| kept.key);
    let uploaded = work(&mut key_holder, &key, is_provisioned);
    if !is_sound {
        return;
    }
    assert!(
        matches!(
            uploaded,
            Ok(Response::Committed(_)) | Err(Refusal::AlreadyActive)
        ),
        "{uploaded:?}"
    );
    let (key_holder, started) = KeyHolder::start(Shared(nor));
    assert_eq!(started, Ok(()));
    assert_eq!(key_holder.active(), Some(id(&CONTENTS[2])));
}

fn keys(nor: &RefCell<Nor>) -> KeyPages<Shared<'_>> {
    KeyPages::new(Shared(nor), layout(PAGES).key())
}

/// A board whose key is damaged takes no change from anybody, and no key.
fn takes_no_change(nor: &RefCell<Nor>, key_holder: &mut KeyHolder<Shared>) {
    let operations = nor.borrow().operations;
    for key in &KEYS {
        let provisioned = key_holder.change(key, Act::Provision(key.clone()));
        assert_eq!(provisioned, Err(Refusal::KeyDamaged));
        let uploaded = key_holder.upload(key, &CONTENTS[2]);
        assert_eq!(uploaded, Err(Refusal::KeyDamaged));
    }
    assert_eq!(nor.borrow().operations, operations);
}

fn work(
    key_holder: &mut KeyHolder<Shared>,
    key: &Key,
    is_provisioned: bool,
) -> Result<Response, Refusal> {
    if !is_provisioned {
        key_holder.change(key, Act::Provision(key.clone()))?;
    }
    key_holder.upload(key, &CONTENTS[2])
}
