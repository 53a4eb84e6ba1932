//! The hooks through which the emulator calls back: before every block, and at accesses that it cannot make by itself.

use std::ops::RangeInclusive;

use unicorn_engine::{HookType, MemType, Prot, RegisterARM, TlbEntry, TlbType, Unicorn, uc_error};

use super::context::{Context, Pause};
use super::counting::Counting;
use super::faults::BadAccess;
use super::instructions::{self, BlockInfo};
use super::mapping::{map_memories, map_registers};
use super::stub::{STUB_BASE, Stub};
use crate::memory::{CCM_BASE, CCM_SIZE, FLASH_BASE, FLASH_SIZE, RAM_BASE, RAM_SIZE};
use crate::peripherals::Cycles;
use crate::peripherals::nvic::Masks;

/// Everything but RAM. A hook over RAM would make every store to it slow.
const BESIDE_RAM: [RangeInclusive<u32>; 3] = [
    0..=CCM_BASE - 1,
    CCM_BASE + CCM_SIZE as u32..=RAM_BASE - 1,
    RAM_BASE + RAM_SIZE as u32..=u32::MAX,
];
/// Bits of xPSR that are not zero within an IT block.
pub(super) const IT_STATE: u32 = 0x0600_FC00;

/// Maps memories and registers and adds the hooks.
pub(super) fn connect(uc: &mut Unicorn<'static, Context>, stub: &Stub) -> Result<(), uc_error> {
    map_memories(uc, stub)?;
    map_registers(uc)?;
    add_hooks(uc)
}

/// The core's masks.
pub(super) fn masks_of(uc: &Unicorn<'_, Context>) -> Masks {
    Masks {
        primask: register_of(uc, RegisterARM::PRIMASK) & 1 != 0,
        faultmask: register_of(uc, RegisterARM::FAULTMASK) & 1 != 0,
        basepri: register_of(uc, RegisterARM::BASEPRI) as u8,
    }
}

/// A register of the core.
pub(super) fn register_of(uc: &Unicorn<'_, Context>, register: impl Into<i32>) -> u32 {
    // The registers are constants that exist on this core.
    uc.reg_read(register).unwrap_or(0) as u32
}

fn add_hooks(uc: &mut Unicorn<'static, Context>) -> Result<(), uc_error> {
    uc.ctl_set_tlb_type(TlbType::VIRTUAL)?;
    uc.add_tlb_hook(1, 0, translate)?;
    uc.add_block_hook(1, 0, on_block)?;
    uc.add_intr_hook(|uc, number| {
        uc.get_data_mut().raised = Some(number);
        stop(uc);
    })?;
    for area in BESIDE_RAM {
        let (begin, end) = (u64::from(*area.start()), u64::from(*area.end()));
        uc.add_mem_hook(
            HookType::MEM_UNMAPPED,
            begin,
            end,
            |uc, kind, address, _, _| {
                uc.get_data_mut().bad_access = Some(BadAccess {
                    kind,
                    address: address as u32,
                });
                false
            },
        )?;
        uc.add_mem_hook(HookType::MEM_PROT, begin, end, on_protected)?;
    }
    Ok(())
}

fn stop(uc: &mut Unicorn<'_, Context>) {
    // It fails only if the emulator does not run, and it runs: this is a hook.
    let _ = uc.emu_stop();
}

/// Maps every address to itself. The emulator watches stores to executable pages, which makes them slow; so a page of
/// RAM is executable only after code has run from it.
fn translate(uc: &mut Unicorn<'_, Context>, address: u64, kind: MemType) -> Option<TlbEntry> {
    let within = |base: u32, size: usize| {
        (u64::from(base)..u64::from(base) + size as u64).contains(&address)
    };
    if kind != MemType::FETCH {
        forget_condition(uc);
    }
    let code_in_ram = &mut uc.get_data_mut().code_in_ram;
    if kind == MemType::FETCH {
        code_in_ram.insert(address);
    }
    let in_ram = within(RAM_BASE, RAM_SIZE) || within(CCM_BASE, CCM_SIZE);
    let only_data = in_ram && !code_in_ram.contains(&address);
    let perms = if only_data {
        Prot::READ | Prot::WRITE
    } else {
        Prot::ALL
    };
    Some(TlbEntry {
        paddr: address,
        perms,
    })
}

/// Before it asks about a load or store, the emulator writes back the core's state at that instruction, within an IT
/// block with its condition. The block then goes on and expects no condition there. A condition left behind would
/// become the state of the first block that is looked up later.
fn forget_condition(uc: &mut Unicorn<'_, Context>) {
    const ONLY_THUMB: u64 = 1 << 24;
    // The register is a constant that exists on this core.
    let _ = uc.reg_write(RegisterARM::EPSR, ONLY_THUMB);
}

fn on_block(uc: &mut Unicorn<'_, Context>, address: u64, size: u32) {
    let address = address as u32;
    let context = uc.get_data_mut();
    if context.cycles >= context.attention && !is_stub(address) && !may_run(uc, address) {
        stop(uc);
        return;
    }
    let context = uc.get_data_mut();
    let area = Context::area_of(address);
    let info = context.blocks[area]
        .get(address, size)
        .unwrap_or_else(|| decode_block(uc, area, address, size));
    if uc.get_data().counting.is_some() {
        count(uc, address, info);
    }
    let context = uc.get_data_mut();
    context.block_end = address.wrapping_add(size);
    context.cycles += Cycles::from(info.instructions);
    context.event |= info.sends_event;
}

/// Reports a block that is about to run to the counting.
fn count(uc: &mut Unicorn<'_, Context>, address: u32, info: BlockInfo) {
    let registers = uc
        .get_data()
        .counting
        .as_ref()
        .is_some_and(|counting| counting.looks_at(address))
        .then(|| [RegisterARM::SP, RegisterARM::LR].map(|register| register_of(uc, register)));
    let stale = |counting: &Counting| counting.masking.stale;
    let masks = uc.get_data().counting.as_ref().is_some_and(stale);
    let masks = masks.then(|| masks_of(uc));
    let context = uc.get_data_mut();
    if let Some(counting) = &mut context.counting {
        if let Some([stack, link]) = registers {
            counting.arrive(address, stack, link);
        }
        if let Some(masks) = masks {
            let nvic = &context.bus.nvic;
            let masked = nvic.masked_priority(masks) < nvic.running_priority();
            counting.masking.arrive(masked, address, context.cycles);
        }
        counting.masking.stale = info.changes_masks;
        counting.execute(info.instructions);
    }
}

fn is_stub(address: u32) -> bool {
    address & 0xFFFF_F000 == STUB_BASE
}

/// Whether the block at `address` may run, after everything that is due has been carried out.
fn may_run(uc: &mut Unicorn<'_, Context>, address: u32) -> bool {
    let context = uc.get_data_mut();
    context.catch_up_for_block(address);
    let (masks, in_it_block) = if context.masks_matter(address) {
        (
            masks_of(uc),
            register_of(uc, RegisterARM::XPSR) & IT_STATE != 0,
        )
    } else {
        (Masks::default(), false)
    };
    let context = uc.get_data_mut();
    context.pause = context.reason_to_pause(address, masks, in_it_block);
    context.attention = context.next_attention();
    context.pause == Pause::None
}

#[cold]
fn decode_block(uc: &mut Unicorn<'_, Context>, area: usize, address: u32, size: u32) -> BlockInfo {
    if is_stub(address) {
        return BlockInfo {
            instructions: 0,
            sends_event: false,
            changes_masks: false,
        };
    }
    let mut code = vec![0; size as usize];
    if uc.mem_read(u64::from(address), &mut code).is_err() {
        return BlockInfo {
            instructions: 1,
            sends_event: false,
            changes_masks: false,
        };
    }
    let info = instructions::decode(&code);
    uc.get_data_mut().blocks[area].insert(address, size, info);
    info
}

/// The flash interface decides about a store into flash; a read of a watched bank may have to wait, or find a torn
/// word. Any other access is a fault.
fn on_protected(
    uc: &mut Unicorn<'_, Context>,
    kind: MemType,
    address: u64,
    size: usize,
    value: i64,
) -> bool {
    let context = uc.get_data_mut();
    let address = address as u32;
    let offset = match address {
        FLASH_BASE..=0x0807_FFFF => Some((address - FLASH_BASE) as usize),
        _ => Some(address as usize).filter(|offset| *offset < FLASH_SIZE),
    };
    match (kind, offset) {
        (MemType::WRITE_PROT, Some(offset)) => context.store_to_flash(offset, value as u32, size),
        (MemType::READ_PROT, Some(offset)) => context.look_at_flash(offset),
        _ => {
            context.bad_access = Some(BadAccess { kind, address });
            return false;
        }
    }
    forget_condition(uc);
    true
}
