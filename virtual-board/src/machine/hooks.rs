//! The emulator's surroundings: memories and registers mapped into it, and the hooks through which it calls back.

use std::ops::RangeInclusive;

use unicorn_engine::{HookType, MemType, Prot, RegisterARM, TlbEntry, TlbType, Unicorn, uc_error};

use super::bus::FLASH_SIZE;
use super::context::{Context, Pause};
use super::faults::BadAccess;
use super::instructions::{self, BlockInfo};
use super::memory::{
    Block, CCM_BASE, CCM_SIZE, FLASH_BASE, RAM_BASE, RAM_SIZE, SYSTEM_BASE, SYSTEM_SIZE,
};
use crate::peripherals::Cycles;
use crate::peripherals::flash::BANK_SIZE;
use crate::peripherals::nvic::Masks;

/// Registers of the buses AHB1/APB1/APB2, AHB2, and of the core itself.
const REGISTER_AREAS: [RangeInclusive<u32>; 4] = [
    0x4000_0000..=0x4002_FFFF,
    0x4800_0000..=0x4800_1FFF,
    0x5000_0000..=0x5006_0FFF,
    0xE000_0000..=0xE00F_FFFF,
];
/// Everything but RAM. A hook that covers RAM would make every store to it slow.
const BESIDE_RAM: [RangeInclusive<u32>; 3] = [
    0..=CCM_BASE - 1,
    CCM_BASE + CCM_SIZE as u32..=RAM_BASE - 1,
    RAM_BASE + RAM_SIZE as u32..=u32::MAX,
];
/// A page of the code area that does not exist on the chip, for the instructions of the model's own.
pub(super) const STUB_BASE: u32 = 0x1E00_0000;
/// Bits of xPSR that are not zero within an IT block.
pub(super) const IT_STATE: u32 = 0x0600_FC00;

/// Sets everything up.
pub(super) fn connect(uc: &mut Unicorn<'static, Context>, stub: &Block) -> Result<(), uc_error> {
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
pub(super) fn register_of(uc: &Unicorn<'_, Context>, register: RegisterARM) -> u32 {
    // The registers are constants that exist on this core.
    uc.reg_read(register).unwrap_or(0) as u32
}

fn map_memories(uc: &mut Unicorn<'static, Context>, stub: &Block) -> Result<(), uc_error> {
    let code = Prot::READ | Prot::EXEC;
    let bus = &uc.get_data().bus;
    let flash = bus.flash_memory.block();
    let ccm = bus.ram.address(RAM_SIZE - CCM_SIZE);
    let regions = [
        (FLASH_BASE, BANK_SIZE, code, flash.address(0)),
        (
            FLASH_BASE + BANK_SIZE as u32,
            BANK_SIZE,
            code,
            flash.address(BANK_SIZE),
        ),
        (0, BANK_SIZE, code, flash.address(0)),
        (BANK_SIZE as u32, BANK_SIZE, code, flash.address(BANK_SIZE)),
        (RAM_BASE, RAM_SIZE, Prot::ALL, bus.ram.address(0)),
        (CCM_BASE, CCM_SIZE, Prot::ALL, ccm),
        (SYSTEM_BASE, SYSTEM_SIZE, Prot::READ, bus.system.address(0)),
        (STUB_BASE, stub.size(), code, stub.address(0)),
    ];
    for (base, size, rights, memory) in regions {
        // SAFETY: the memory belongs to blocks that live as long as the emulator: they are its data, or stand beside
        // it in `Machine`, declared after it and so dropped later. They are only ever accessed through raw copies.
        unsafe { uc.mem_map_ptr(u64::from(base), size as u64, Prot::ALL, memory.cast())? };
        // Only a change of rights makes the emulator drop stores to memory that is not writable.
        uc.mem_protect(u64::from(base), size as u64, rights)?;
    }
    Ok(())
}

/// Lets the core reach bank 2 of the flash directly, or, while words in it do not match their error code, by way of this
/// program: the emulator tells of the first read of a page, but not of every one that follows. No code is in that bank.
pub(super) fn map_bank_2(
    uc: &mut Unicorn<'static, Context>,
    directly: bool,
) -> Result<(), uc_error> {
    const SIZE: u64 = BANK_SIZE as u64;
    for base in [FLASH_BASE + BANK_SIZE as u32, BANK_SIZE as u32] {
        uc.mem_unmap(u64::from(base), SIZE)?;
        if directly {
            let memory = uc.get_data().bus.flash_memory.block().address(BANK_SIZE);
            // SAFETY: as for the other memories, see `map_memories`.
            unsafe { uc.mem_map_ptr(u64::from(base), SIZE, Prot::ALL, memory.cast())? };
            uc.mem_protect(u64::from(base), SIZE, Prot::READ | Prot::EXEC)?;
            continue;
        }
        uc.mmio_map(
            u64::from(base),
            SIZE,
            Some(|uc: &mut Unicorn<'_, Context>, offset: u64, size: usize| {
                let context = uc.get_data_mut();
                let offset = BANK_SIZE + offset as usize;
                context.look_at_flash(offset);
                context.bus.flash_memory.value(offset, size)
            }),
            Some(
                |uc: &mut Unicorn<'_, Context>, offset: u64, size: usize, value: u64| {
                    let offset = BANK_SIZE + offset as usize;
                    uc.get_data_mut().store_to_flash(offset, value as u32, size);
                },
            ),
        )?;
    }
    Ok(())
}

fn map_registers(uc: &mut Unicorn<'static, Context>) -> Result<(), uc_error> {
    for area in REGISTER_AREAS {
        let base = *area.start();
        let size = u64::from(area.end() - base) + 1;
        uc.mmio_map(
            u64::from(base),
            size,
            Some(
                move |uc: &mut Unicorn<'_, Context>, offset: u64, size: usize| {
                    let context = uc.get_data_mut();
                    context.before_access();
                    u64::from(context.bus.read(base + offset as u32, size as u32))
                },
            ),
            Some(
                move |uc: &mut Unicorn<'_, Context>, offset: u64, size: usize, value: u64| {
                    let context = uc.get_data_mut();
                    context.before_access();
                    context
                        .bus
                        .write(base + offset as u32, value as u32, size as u32);
                },
            ),
        )?;
    }
    Ok(())
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
    // It fails only for an emulator that does not run, and this one does: it is in a hook.
    let _ = uc.emu_stop();
}

/// Every address is itself. The emulator watches stores to pages that may be executed, which makes them slow; so a page
/// of RAM may be executed only once it has been.
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

/// Before it asks about a load or store, the emulator writes the core's state back as it is at that instruction, within
/// an IT block with its condition. But the block goes on, and expects no condition to be there; left behind, it would be
/// taken for the state of the first block that is looked up later.
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
        count(uc, address, info.instructions);
    }
    let context = uc.get_data_mut();
    context.block_end = address.wrapping_add(size);
    context.cycles += Cycles::from(info.instructions);
    context.event |= info.sends_event;
}

/// Shows a block that will run to the counts that were asked for.
fn count(uc: &mut Unicorn<'_, Context>, address: u32, instructions: u32) {
    let registers = uc
        .get_data()
        .counting
        .as_ref()
        .is_some_and(|counting| counting.looks_at(address))
        .then(|| [RegisterARM::SP, RegisterARM::LR].map(|register| register_of(uc, register)));
    if let Some(counting) = &mut uc.get_data_mut().counting {
        if let Some([stack, link]) = registers {
            counting.arrive(address, stack, link);
        }
        counting.execute(instructions);
    }
}

fn is_stub(address: u32) -> bool {
    address & 0xFFFF_F000 == STUB_BASE
}

/// A closer look at what is due before the block at `address`.
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
        };
    }
    let mut code = vec![0; size as usize];
    if uc.mem_read(u64::from(address), &mut code).is_err() {
        return BlockInfo {
            instructions: 1,
            sends_event: false,
        };
    }
    let info = instructions::decode(&code);
    uc.get_data_mut().blocks[area].insert(address, size, info);
    info
}

/// A store into flash is for the flash interface to judge; a read of a watched bank may have to wait, or find a torn
/// word. Anything else is a fault.
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
