//! The factory words of the system memory (data sheet DS12288, 3.18; RM0440 chapter 48): calibration of the internal
//! channels, unique identifier, size of the flash memory, package.

use super::block::Block;
use super::{SYSTEM_BASE, SYSTEM_SIZE};

/// Supply at which the factory calibrated the internal channels, V.
const CALIBRATION_SUPPLY_V: f64 = 3.0;
/// Temperatures of the two calibration points of the sensor, °C.
const CALIBRATION_C: [f64; 2] = [30.0, 130.0];
/// The sensor's voltage at 30 °C, V, and its slope, V/K (data sheet, typical).
const SENSOR_AT_30C_V: f64 = 0.76;
const SENSOR_SLOPE_V_PER_K: f64 = 2.5e-3;

const UNIQUE_ID: u32 = 0x1FFF_7590;
const TS_CAL1: u32 = 0x1FFF_75A8;
const VREFINT_CAL: u32 = 0x1FFF_75AA;
const TS_CAL2: u32 = 0x1FFF_75CA;
const PACKAGE: u32 = 0x1FFF_7500;
const FLASH_KILOBYTES: u32 = 0x1FFF_75E0;
const OPTION_BYTES: u32 = 0x1FFF_7800;
/// Package code of LQFP64.
const LQFP64: u16 = 0b0_0000;

/// The temperature sensor's voltage, V, at a temperature of the die, °C.
pub fn sensor_voltage(temperature_c: f64) -> f64 {
    SENSOR_AT_30C_V + SENSOR_SLOPE_V_PER_K * (temperature_c - CALIBRATION_C[0])
}

/// The system memory of a chip with this identifier and this internal reference, V.
pub fn build(unique_id: [u8; 12], vrefint_v: f64) -> Block {
    let code = |volt: f64| ((volt / CALIBRATION_SUPPLY_V * 4096.0).round() as u16).to_le_bytes();
    let mut block = Block::new(SYSTEM_SIZE);
    let mut put = |address: u32, bytes: &[u8]| {
        assert!(
            block.write((address - SYSTEM_BASE) as usize, bytes),
            "addresses are constants"
        );
    };
    put(UNIQUE_ID, &unique_id);
    put(VREFINT_CAL, &code(vrefint_v));
    put(TS_CAL1, &code(sensor_voltage(CALIBRATION_C[0])));
    put(TS_CAL2, &code(sensor_voltage(CALIBRATION_C[1])));
    put(PACKAGE, &LQFP64.to_le_bytes());
    put(
        FLASH_KILOBYTES,
        &((super::FLASH_SIZE / 1024) as u16).to_le_bytes(),
    );
    put(OPTION_BYTES, &0xFFEF_F8AA_u32.to_le_bytes());
    block
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_word(block: &Block, address: u32) -> u16 {
        let mut bytes = [0; 2];
        assert!(block.read((address - SYSTEM_BASE) as usize, &mut bytes));
        u16::from_le_bytes(bytes)
    }

    #[test]
    fn calibration_words_are_codes_at_three_volts() {
        let block = build([7; 12], 1.2131);
        // 1.2131 V / 3 V · 4096 = 1656.3; 0.76 V and 1.01 V: 1037.7 and 1379.0.
        assert_eq!(half_word(&block, 0x1FFF_75AA), 1656);
        assert_eq!(half_word(&block, 0x1FFF_75A8), 1038);
        assert_eq!(half_word(&block, 0x1FFF_75CA), 1379);
        assert_eq!(half_word(&block, 0x1FFF_75E0), 512);
    }
}
