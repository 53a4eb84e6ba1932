//! The factors of the converters' self-calibration, found once for each power-up.
//!
//! A converter that calibrates itself again finds a factor that may differ by a step, and the offsets of all its channels
//! step with it: between two runs of a campaign that would be an error. The driver calibrates whenever it is built. So the
//! factor that it found first is written back (RM0440, 21.4.8), and a reset changes nothing, because the factors lie in
//! `.uninit`, each with a check.

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;

use embassy_stm32::pac;

use crate::health::resets::Sealed;

/// A converter whose factor is kept.
#[derive(Clone, Copy)]
pub enum Converter {
    /// That of the inertial channels.
    Inertial,
    /// That of the jacks.
    Jacks,
    /// That of supply and temperature.
    Supply,
}

#[unsafe(link_section = ".uninit.factors")]
static mut FACTORS: MaybeUninit<[Sealed<1>; 3]> = MaybeUninit::uninit();

/// Gives a converter that is on, and does not convert, the factor of its first calibration since the power came on. If this
/// is the first, keeps it.
#[inline(never)]
pub fn settle(converter: Converter) {
    let adc = match converter {
        Converter::Inertial => pac::ADC1,
        Converter::Jacks => pac::ADC2,
        Converter::Supply => pac::ADC5,
    };
    // SAFETY: each element belongs to the task that owns the converter. Every bit pattern is a valid element; it is accessed
    // volatile, because the compiler knows of no write to it before.
    unsafe {
        let kept = addr_of_mut!(FACTORS)
            .cast::<Sealed<1>>()
            .add(converter as usize);
        match kept.read_volatile().open() {
            Some([factor]) => adc.calfact().write_value(pac::adc::regs::Calfact(factor)),
            None => kept.write_volatile(Sealed::new([adc.calfact().read().0])),
        }
    }
}
