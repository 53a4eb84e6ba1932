//! The memories and registers, mapped into the emulator.

use std::ops::RangeInclusive;

use unicorn_engine::{Prot, Unicorn, uc_error};

use super::context::Context;
use super::stub::{STUB_BASE, Stub};
use crate::memory::{
    BANK_SIZE, CCM_BASE, CCM_SIZE, FLASH_BASE, RAM_BASE, RAM_SIZE, SYSTEM_BASE, SYSTEM_SIZE,
};

/// Registers of the buses AHB1/APB1/APB2, AHB2, and of the core itself.
const REGISTER_AREAS: [RangeInclusive<u32>; 4] = [
    0x4000_0000..=0x4002_FFFF,
    0x4800_0000..=0x4800_1FFF,
    0x5000_0000..=0x5006_0FFF,
    0xE000_0000..=0xE00F_FFFF,
];
/// Maps the memories.
pub(super) fn map_memories(
    uc: &mut Unicorn<'static, Context>,
    stub: &Stub,
) -> Result<(), uc_error> {
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
        (
            STUB_BASE,
            stub.block().size(),
            code,
            stub.block().address(0),
        ),
    ];
    for (base, size, rights, memory) in regions {
        // SAFETY: the memory belongs to blocks that live as long as the emulator: they are its data, or stand beside it
        // in `Machine`, declared after it and so dropped later. Only raw copies ever access them.
        unsafe { uc.mem_map_ptr(u64::from(base), size as u64, Prot::ALL, memory.cast())? };
        // The emulator drops stores to read-only memory only after a change of rights.
        uc.mem_protect(u64::from(base), size as u64, rights)?;
    }
    Ok(())
}

/// Lets the core reach bank 2 of the flash directly. While words in it do not match their error code, the core reaches
/// it through this program: the emulator reports the first read of a page, but not every later one. No code is in that
/// bank.
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

/// Maps the registers.
pub(super) fn map_registers(uc: &mut Unicorn<'static, Context>) -> Result<(), uc_error> {
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
