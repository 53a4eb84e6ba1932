//! Interrupt controller and system control block (ARMv7-M B1.5, B3.2, B3.4), with the chip's 102 interrupts and 16
//! priority levels.
//!
//! Exceptions are numbered as the core numbers them: 2 NMI, 3 HardFault, 11 SVCall, 14 PendSV, 15 SysTick, 16 + n for
//! interrupt n. Priorities are the values in the registers, lower is more urgent; HardFault is −1, NMI −2, thread mode
//! 256. Interrupt lines are levels: a line that is still high when its handler returns makes it pending again.

mod registers;

use super::{bit, field};

/// Interrupts of the chip.
pub const INTERRUPTS: usize = 102;
/// Exceptions: the core's 16 and the chip's interrupts.
pub const EXCEPTIONS: usize = 16 + INTERRUPTS;

/// Non-maskable interrupt.
pub const NMI: usize = 2;
/// HardFault.
pub const HARD_FAULT: usize = 3;
/// MemManage fault.
pub const MEM_MANAGE: usize = 4;
/// BusFault.
pub const BUS_FAULT: usize = 5;
/// UsageFault.
pub const USAGE_FAULT: usize = 6;
/// Supervisor call.
pub const SV_CALL: usize = 11;
/// PendSV.
pub const PEND_SV: usize = 14;
/// SysTick.
pub const SYS_TICK: usize = 15;

/// Priority of code outside of exceptions: beneath every exception.
pub const THREAD_PRIORITY: i32 = 256;

/// The core's masks, which are in the processor model.
#[derive(Debug, Clone, Copy, Default)]
pub struct Masks {
    /// PRIMASK.
    pub primask: bool,
    /// FAULTMASK.
    pub faultmask: bool,
    /// BASEPRI.
    pub basepri: u8,
}

/// Controller and system control block.
#[derive(Debug)]
pub struct Nvic {
    enabled: u128,
    pending: u128,
    active: u128,
    lines: u128,
    priorities: [u8; EXCEPTIONS],
    /// Priority of the most urgent active exception.
    running_priority: i32,
    vtor: u32,
    prigroup: u32,
    scr: u32,
    ccr: u32,
    shcsr: u32,
    cfsr: u32,
    hfsr: u32,
    mmfar: u32,
    bfar: u32,
    cpacr: u32,
    fpccr: u32,
    fpcar: u32,
    fpdscr: u32,
    reset_requested: bool,
}

impl Default for Nvic {
    fn default() -> Self {
        Self {
            // The core's own exceptions cannot be disabled, but for the three configurable faults (SHCSR).
            enabled: 0xFFFF & !(1 << MEM_MANAGE | 1 << BUS_FAULT | 1 << USAGE_FAULT),
            pending: 0,
            active: 0,
            lines: 0,
            priorities: [0; EXCEPTIONS],
            running_priority: THREAD_PRIORITY,
            vtor: 0,
            prigroup: 0,
            scr: 0,
            ccr: 0x0000_0200,
            shcsr: 0,
            cfsr: 0,
            hfsr: 0,
            mmfar: 0,
            bfar: 0,
            cpacr: 0,
            fpccr: 0xC000_0000,
            fpcar: 0,
            fpdscr: 0,
            reset_requested: false,
        }
    }
}

impl Nvic {
    /// Sets the level of interrupt line `number`; a rising line makes the interrupt pending.
    pub fn set_line(&mut self, number: usize, high: bool) {
        let mask = 1 << (16 + number);
        if high {
            self.pending |= mask & !self.lines;
            self.lines |= mask;
        } else {
            self.lines &= !mask;
        }
    }

    /// Makes an exception pending.
    pub fn pend(&mut self, exception: usize) {
        self.pending |= 1 << exception;
    }

    /// Whether an enabled exception with a higher priority than the running code is pending, without regard to masks.
    pub fn may_preempt(&self) -> bool {
        self.pending & self.enabled != 0
            && self
                .most_urgent()
                .is_some_and(|(_, group)| group < self.running_priority)
    }

    /// Whether any exception is pending, enabled or not (for SEVONPEND).
    pub fn any_pending(&self) -> bool {
        self.pending != 0
    }

    /// The exception that the core must take now, if any.
    pub fn to_take(&self, masks: Masks) -> Option<usize> {
        if self.pending & self.enabled == 0 {
            return None;
        }
        let (exception, group) = self.most_urgent()?;
        (group < self.masked_priority(masks)).then_some(exception)
    }

    /// The priority that an exception must exceed to be taken: the running one's, boosted by the masks.
    pub fn masked_priority(&self, masks: Masks) -> i32 {
        let mut priority = self.running_priority;
        if masks.basepri != 0 {
            priority = priority.min(self.group(masks.basepri));
        }
        if masks.primask {
            priority = priority.min(0);
        }
        if masks.faultmask {
            priority = priority.min(-1);
        }
        priority
    }

    /// Whether a fault exception of this number can be taken at the current priority; otherwise it escalates to
    /// HardFault.
    pub fn can_take_fault(&self, fault: usize, masks: Masks) -> bool {
        bit128(self.enabled, fault) && self.group_priority(fault) < self.masked_priority(masks)
    }

    /// Enters an exception.
    pub fn activate(&mut self, exception: usize) {
        self.pending &= !(1 << exception);
        self.active |= 1 << exception;
        self.recompute_running();
    }

    /// Returns from an exception.
    pub fn deactivate(&mut self, exception: usize) {
        self.active &= !(1 << exception);
        self.pending |= self.lines & (1 << exception);
        self.recompute_running();
    }

    /// Whether more than one exception is active.
    pub fn nested(&self) -> bool {
        self.active & (self.active.wrapping_sub(1)) != 0
    }

    /// Whether no exception is active.
    pub fn idle(&self) -> bool {
        self.active == 0
    }

    /// Priority of the most urgent active exception.
    pub fn running_priority(&self) -> i32 {
        self.running_priority
    }

    /// The running exception: the most urgent active one.
    pub fn vect_active(&self) -> u32 {
        (0..EXCEPTIONS)
            .filter(|&exception| bit128(self.active, exception))
            .min_by_key(|&exception| self.group_priority(exception))
            .unwrap_or(0) as u32
    }

    /// Base address of the vector table.
    pub fn vector_table(&self) -> u32 {
        self.vtor
    }

    /// CCR.STKALIGN: whether exception frames are aligned to eight bytes.
    pub fn aligns_frames(&self) -> bool {
        bit(self.ccr, 9)
    }

    /// SCR.SLEEPONEXIT.
    pub fn sleeps_on_exit(&self) -> bool {
        bit(self.scr, 1)
    }

    /// SCR.SEVONPEND.
    pub fn event_on_pend(&self) -> bool {
        bit(self.scr, 4)
    }

    /// Whether the floating-point unit is switched on (CPACR).
    pub fn fpu_on(&self) -> bool {
        field(self.cpacr, 20, 4) == 0xF
    }

    /// Whether the floating-point context is saved on exception entry (FPCCR.ASPEN).
    pub fn saves_fp_context(&self) -> bool {
        bit(self.fpccr, 31)
    }

    /// FPDSCR, the default for FPSCR in a new floating-point context.
    pub fn default_fpscr(&self) -> u32 {
        self.fpdscr
    }

    /// Adds fault status: bits of CFSR, and the address in MMFAR or BFAR if there is one.
    pub fn note_fault(&mut self, cfsr: u32, address: Option<u32>) {
        self.cfsr |= cfsr;
        if let Some(address) = address {
            if cfsr & 0x80 != 0 {
                self.mmfar = address;
            } else {
                self.bfar = address;
            }
        }
    }

    /// Adds bits of HFSR.
    pub fn note_hard_fault(&mut self, hfsr: u32) {
        self.hfsr |= hfsr;
    }

    /// Collects a reset request (AIRCR.SYSRESETREQ).
    pub fn take_reset_request(&mut self) -> bool {
        std::mem::take(&mut self.reset_requested)
    }

    fn most_urgent(&self) -> Option<(usize, i32)> {
        let mut candidates = self.pending & self.enabled;
        let mut best: Option<(usize, (i32, i32))> = None;
        while candidates != 0 {
            let exception = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            // Within a group the sub-priority decides, then the number.
            let key = (self.group_priority(exception), self.priority(exception));
            if best.is_none_or(|(_, least)| key < least) {
                best = Some((exception, key));
            }
        }
        best.map(|(exception, (group, _))| (exception, group))
    }

    fn priority(&self, exception: usize) -> i32 {
        match exception {
            NMI => -2,
            HARD_FAULT => -1,
            _ => i32::from(self.priorities[exception]),
        }
    }

    fn group_priority(&self, exception: usize) -> i32 {
        match exception {
            NMI | HARD_FAULT => self.priority(exception),
            _ => self.group(self.priorities[exception]),
        }
    }

    /// The part of a priority that decides about pre-emption (AIRCR.PRIGROUP).
    fn group(&self, priority: u8) -> i32 {
        i32::from(priority) & !((2 << self.prigroup) - 1)
    }

    fn recompute_running(&mut self) {
        let mut active = self.active;
        self.running_priority = THREAD_PRIORITY;
        while active != 0 {
            let exception = active.trailing_zeros() as usize;
            active &= active - 1;
            self.running_priority = self.running_priority.min(self.group_priority(exception));
        }
    }
}

fn bit128(set: u128, index: usize) -> bool {
    set & (1 << index) != 0
}
