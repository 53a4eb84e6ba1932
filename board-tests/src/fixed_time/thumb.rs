//! As much of the Thumb-2 instruction set as it takes to see where a program goes and what takes time by its operands.
//!
//! Encodings are those of the ARMv7-M Architecture Reference Manual (DDI 0403), chapters A5 to A7. On the Cortex-M4 the
//! duration of divisions and square roots depends on their operands (Technical Reference Manual, instruction set
//! summary: SDIV, UDIV 2 to 12 cycles; VDIV, VSQRT 14).

/// What an instruction does beside computing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    Plain,
    /// Goes on, perhaps, at this address.
    Branch(u32),
    /// Goes on at an address out of a register or memory, and is no return.
    ThroughPointer,
    /// A division or square root, by its name.
    Slow(&'static str),
}

/// Whether an instruction that begins with this half-word has a second one (A5.1).
pub fn is_wide(first: u16) -> bool {
    first >> 11 >= 0b11101
}

/// Effect of the instruction of one half-word at `address` (A5.2).
pub fn narrow(address: u32, code: u16) -> Effect {
    const LINK_REGISTER: u16 = 14;
    let after = address.wrapping_add(4);
    let to_pc = |opcode: u16| code & 0xFF87 == opcode;
    match code {
        // B<c>, not UDF and SVC.
        _ if code & 0xF000 == 0xD000 && code & 0x0E00 != 0x0E00 => {
            Effect::Branch(after.wrapping_add_signed(signed(u32::from(code & 0xFF), 8) * 2))
        }
        _ if code & 0xF800 == 0xE000 => {
            Effect::Branch(after.wrapping_add_signed(signed(u32::from(code & 0x7FF), 11) * 2))
        }
        // CBZ, CBNZ.
        _ if code & 0xF500 == 0xB100 => {
            let offset = (code >> 3 & 0x40) | (code >> 2 & 0x3E);
            Effect::Branch(after + u32::from(offset))
        }
        // BLX, ADD pc, MOV pc.
        _ if code & 0xFF87 == 0x4780 || to_pc(0x4487) || to_pc(0x4687) => Effect::ThroughPointer,
        // BX, which with the link register is a return.
        _ if code & 0xFF87 == 0x4700 && code >> 3 & 0xF != LINK_REGISTER => Effect::ThroughPointer,
        _ => Effect::Plain,
    }
}

/// Effect of the instruction of two half-words at `address` (A5.3).
pub fn wide(address: u32, first: u16, second: u16) -> Effect {
    const STACK_POINTER: u16 = 13;
    let loads_pc = first & 0xFF70 == 0xF850 && second >> 12 == 15;
    let pops_pc = (first, second) == (0xF85D, 0xFB04);
    let loads_many_with_pc =
        first & 0xFE50 == 0xE810 && first & 0x0180 != 0x0180 && second >> 15 == 1;
    match (first, second) {
        _ if first & 0xFFF0 == 0xFB90 && second & 0xF0 == 0xF0 => Effect::Slow("SDIV"),
        _ if first & 0xFFF0 == 0xFBB0 && second & 0xF0 == 0xF0 => Effect::Slow("UDIV"),
        _ if first & 0xFFB0 == 0xEE80 && second & 0x0E50 == 0x0A00 => Effect::Slow("VDIV"),
        _ if first & 0xFFBF == 0xEEB1 && second & 0x0ED0 == 0x0AC0 => Effect::Slow("VSQRT"),
        // BL and B.
        _ if first & 0xF800 == 0xF000 && second & 0x9000 == 0x9000 => {
            Effect::Branch(address.wrapping_add_signed(4 + far(first, second)))
        }
        // B<c>, not the miscellaneous instructions beside it.
        _ if first & 0xF800 == 0xF000 && second & 0xD000 == 0x8000 && first & 0x0380 != 0x0380 => {
            Effect::Branch(address.wrapping_add_signed(4 + near(first, second)))
        }
        _ if loads_pc && !pops_pc => Effect::ThroughPointer,
        _ if loads_many_with_pc && first & 0xF != STACK_POINTER => Effect::ThroughPointer,
        _ => Effect::Plain,
    }
}

/// Offset of BL and of the unconditional B: S:I1:I2:imm10:imm11:0, where I = NOT(J XOR S).
fn far(first: u16, second: u16) -> i32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let sign = first >> 10 & 1;
    let inverted = |bit: u32| (second >> bit & 1) ^ sign ^ 1;
    let upper = sign << 2 | inverted(13) << 1 | inverted(11);
    signed(upper << 21 | (first & 0x3FF) << 11 | second & 0x7FF, 24) * 2
}

/// Offset of the conditional B: S:J2:J1:imm6:imm11:0.
fn near(first: u16, second: u16) -> i32 {
    let (first, second) = (u32::from(first), u32::from(second));
    let upper = (first >> 10 & 1) << 2 | (second >> 11 & 1) << 1 | second >> 13 & 1;
    signed(upper << 17 | (first & 0x3F) << 11 | second & 0x7FF, 20) * 2
}

fn signed(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_and_square_roots_are_slow_and_their_neighbours_are_not() {
        // sdiv r0, r1, r2; udiv r9, r10, r11; vdiv.f32 s0, s1, s2; vsqrt.f32 s0, s1.
        assert_eq!(wide(0, 0xFB91, 0xF0F2), Effect::Slow("SDIV"));
        assert_eq!(wide(0, 0xFBBA, 0xF9FB), Effect::Slow("UDIV"));
        assert_eq!(wide(0, 0xEE80, 0x0A81), Effect::Slow("VDIV"));
        assert_eq!(wide(0, 0xEEB1, 0x0AE0), Effect::Slow("VSQRT"));
        // smull r0, r1, r2, r3; umlal r0, r1, r2, r3; smlal r8, r9, r0, r1.
        assert_eq!(wide(0, 0xFB82, 0x0103), Effect::Plain);
        assert_eq!(wide(0, 0xFBE2, 0x0103), Effect::Plain);
        assert_eq!(wide(0, 0xFBC0, 0x8901), Effect::Plain);
        // vmul.f32 s0, s1, s2; vneg.f32 s0, s1; vcvt.f32.u32 s0, s0.
        assert_eq!(wide(0, 0xEE20, 0x0A81), Effect::Plain);
        assert_eq!(wide(0, 0xEEB1, 0x0A60), Effect::Plain);
        assert_eq!(wide(0, 0xEEB8, 0x0A40), Effect::Plain);
    }

    #[test]
    fn branches_go_where_they_say() {
        // bl to itself, b.w 8 behind, bl 0x1000 ahead; beq.w 8 behind; b and beq to themselves; cbz 4 beyond the next.
        assert_eq!(wide(0x100, 0xF7FF, 0xFFFE), Effect::Branch(0x100));
        assert_eq!(wide(0x100, 0xF7FF, 0xBFFA), Effect::Branch(0xF8));
        assert_eq!(wide(0x100, 0xF000, 0xFFFE), Effect::Branch(0x1100));
        assert_eq!(wide(0x100, 0xF43F, 0xAFFA), Effect::Branch(0xF8));
        assert_eq!(narrow(0x100, 0xE7FE), Effect::Branch(0x100));
        assert_eq!(narrow(0x100, 0xD0FE), Effect::Branch(0x100));
        assert_eq!(narrow(0x100, 0xB110), Effect::Branch(0x108));
    }

    #[test]
    fn pointers_are_seen_and_returns_are_none() {
        // blx r3; bx r0; mov pc, r1; ldr.w pc, [r0]; ldmia.w r0, {r1, pc}.
        assert_eq!(narrow(0, 0x4798), Effect::ThroughPointer);
        assert_eq!(narrow(0, 0x4700), Effect::ThroughPointer);
        assert_eq!(narrow(0, 0x468F), Effect::ThroughPointer);
        assert_eq!(wide(0, 0xF8D0, 0xF000), Effect::ThroughPointer);
        assert_eq!(wide(0, 0xE890, 0x8002), Effect::ThroughPointer);
        // bx lr; pop {r7, pc}; pop.w {r4, pc}; ldr pc, [sp], #4.
        assert_eq!(narrow(0, 0x4770), Effect::Plain);
        assert_eq!(narrow(0, 0xBD80), Effect::Plain);
        assert_eq!(wide(0, 0xE8BD, 0x8010), Effect::Plain);
        assert_eq!(wide(0, 0xF85D, 0xFB04), Effect::Plain);
    }
}
