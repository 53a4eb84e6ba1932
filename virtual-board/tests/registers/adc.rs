//! RM0440 chapter 21.

use virtual_board::peripherals::NEVER;
use virtual_board::peripherals::adc::{Adc, AdcCommon, Imperfection};

const ISR: u32 = 0x00;
const CR: u32 = 0x08;
const CFGR: u32 = 0x0C;
const CFGR2: u32 = 0x10;
const SMPR1: u32 = 0x14;
const SMPR2: u32 = 0x18;
const SQR1: u32 = 0x30;
const DR: u32 = 0x40;
const DIFSEL: u32 = 0xB0;

const ADRDY: u32 = 1;
const EOC: u32 = 1 << 2;
const EOS: u32 = 1 << 3;
const OVR: u32 = 1 << 4;
const ADEN: u32 = 1;
const ADDIS: u32 = 1 << 1;
const ADSTART: u32 = 1 << 2;
const ADSTP: u32 = 1 << 4;
const ADVREGEN: u32 = 1 << 28;
const DEEPPWD: u32 = 1 << 29;
const CALFACT: u32 = 0xB4;
const ADCAL: u32 = 1 << 31;
/// EXTEN rising, EXTSEL = 13 (TIM6_TRGO).
const ON_TIM6: u32 = 1 << 10 | 13 << 5;

const PERFECT: Imperfection = Imperfection {
    gain_error: 0.0,
    offset_lsb: 0.0,
    noise_lsb: 0.0,
};

/// ADC clock 37.5 MHz, core 150 MHz: one cycle of the ADC clock is four of the core.
fn powered(imperfection: Imperfection) -> Adc {
    let mut adc = Adc::new(imperfection, super::noise());
    adc.set_clock(37_500_000, 150_000_000);
    adc.write(CR, ADVREGEN, 0).unwrap();
    adc
}

fn ready(imperfection: Imperfection) -> Adc {
    let mut adc = powered(imperfection);
    adc.write(CR, ADVREGEN | ADEN, 0).unwrap();
    adc.advance(60, &mut |_, _| 0.0);
    assert_eq!(adc.read(ISR).unwrap() & ADRDY, ADRDY);
    adc
}

/// Runs all events, with every input at `fraction` of the reference; the instants of the samples.
fn run(adc: &mut Adc, until: u64, fraction: f64) -> Vec<(u8, u64)> {
    let mut sampled = Vec::new();
    while adc.next_event() <= until {
        let at = adc.next_event();
        adc.advance(at, &mut |channel, at| {
            sampled.push((channel, at));
            fraction
        });
    }
    sampled
}

#[test]
fn comes_up_in_deep_power_down_and_ignores_aden_until_the_regulator_is_on() {
    let mut adc = Adc::new(PERFECT, super::noise());
    adc.set_clock(37_500_000, 150_000_000);
    assert_eq!(adc.read(CR), Ok(DEEPPWD));
    assert!(adc.write(CR, DEEPPWD | ADEN, 0).is_err());
    assert_eq!(adc.read(CR).unwrap() & ADEN, 0);
}

#[test]
fn control_bits_only_set_and_zeros_do_nothing() {
    let mut adc = ready(PERFECT);
    adc.write(CR, 0, 100).unwrap();
    assert_eq!(adc.read(CR).unwrap() & (ADEN | ADVREGEN), ADEN | ADVREGEN);
}

#[test]
fn calibration_takes_116_clocks_and_only_while_off() {
    let mut adc = powered(PERFECT);
    adc.write(CR, ADVREGEN | ADCAL, 0).unwrap();
    assert_eq!(adc.next_event(), 116 * 4);
    assert_eq!(adc.read(CR).unwrap() & ADCAL, ADCAL);
    run(&mut adc, 464, 0.0);
    assert_eq!(adc.read(CR).unwrap() & ADCAL, 0);
    let mut on = ready(PERFECT);
    assert!(on.write(CR, ADVREGEN | ADCAL, 100).is_err());
}

#[test]
fn switching_off_takes_a_while_and_clears_adrdy() {
    let mut adc = ready(PERFECT);
    adc.write(CR, ADVREGEN | ADDIS, 100).unwrap();
    assert_eq!(adc.read(CR).unwrap() & ADDIS, ADDIS);
    run(&mut adc, 200, 0.0);
    assert_eq!(adc.read(CR).unwrap() & (ADDIS | ADEN), 0);
    assert_eq!(adc.read(ISR).unwrap() & ADRDY, 0);
}

#[test]
fn one_software_conversion_takes_sampling_and_12_5_cycles() {
    let mut adc = ready(PERFECT);
    // One rank, channel 5, 47.5 cycles of sampling (code 4).
    adc.write(SQR1, 5 << 6, 100).unwrap();
    adc.write(SMPR1, 4 << 15, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 1000).unwrap();
    assert_eq!(adc.next_event(), 1000 + 60 * 4);
    let sampled = run(&mut adc, 2000, 0.25);
    assert_eq!(
        sampled,
        [(5, 1000 + 190)],
        "the voltage is that at the end of sampling, 47.5 cycles"
    );
    assert_eq!(adc.read(ISR).unwrap() & (EOC | EOS), EOC | EOS);
    assert_eq!(adc.read(DR), Ok(1024));
    assert_eq!(adc.read(ISR).unwrap() & EOC, 0, "reading DR clears EOC");
    assert_eq!(
        adc.read(CR).unwrap() & ADSTART,
        0,
        "a software start ends with the sequence"
    );
}

#[test]
fn high_channels_have_their_sampling_times_in_smpr2() {
    let mut adc = ready(PERFECT);
    adc.write(SQR1, 18 << 6, 100).unwrap();
    adc.write(SMPR2, 7 << 24, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 0).unwrap();
    assert_eq!(adc.next_event(), (1281 + 25) * 2);
}

#[test]
fn a_triggered_scan_converts_its_ranks_one_after_another() {
    let mut adc = ready(PERFECT);
    // Two ranks: channels 1 and 15, 2.5 cycles each, oversampled 16 times.
    adc.write(SQR1, 1 | 1 << 6 | 15 << 12, 100).unwrap();
    adc.write(CFGR, ON_TIM6, 100).unwrap();
    adc.write(CFGR2, 1 | 3 << 2, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
    assert_eq!(adc.next_event(), NEVER, "it waits for the trigger");
    adc.trigger(11, 500);
    assert_eq!(adc.next_event(), NEVER, "not for any trigger");
    adc.trigger(13, 1000);
    let sampled = run(&mut adc, 10_000, 0.5);
    // Two cycles of latency; a rank is 16 · 15 cycles; the mean hold is after 7.5 conversions and 2.5 cycles.
    let rank = 16 * 15 * 4;
    let first = 1000 + 8 + (15 * 15 * 4) / 2 + 10;
    assert_eq!(sampled, [(1, first), (15, first + rank)]);
    assert_eq!(
        adc.read(CR).unwrap() & ADSTART,
        ADSTART,
        "and waits for the next trigger"
    );
}

#[test]
fn a_trigger_during_a_scan_is_ignored() {
    let mut adc = ready(PERFECT);
    adc.write(CFGR, ON_TIM6, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
    adc.trigger(13, 1000);
    let end = adc.next_event();
    adc.trigger(13, end - 1);
    assert_eq!(adc.next_event(), end);
    assert_eq!(run(&mut adc, 100_000, 0.0).len(), 1);
}

#[test]
fn oversampling_adds_and_shifts_with_rounding() {
    let full = |cfgr2: u32, fraction: f64| {
        let mut adc = ready(PERFECT);
        adc.write(CFGR2, cfgr2, 100).unwrap();
        adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
        run(&mut adc, 10_000_000, fraction);
        adc.read(DR).unwrap()
    };
    assert_eq!(full(0, 1.0), 4095);
    assert_eq!(full(1 | 3 << 2, 1.0), 16 * 4095, "ratio 16, no shift");
    assert_eq!(
        full(1 | 7 << 2 | 4 << 5, 1.0),
        256 * 4095 / 16,
        "ratio 256, shifted by 4"
    );
    // 4 · 1001 = 4004; shifted by 3 is 500.5, rounded to 501 (21.4.30).
    assert_eq!(full(1 | 1 << 2 | 3 << 5, 1001.0 / 4096.0), 501);
}

#[test]
fn each_conversion_is_quantised_with_its_own_noise() {
    let noisy = Imperfection {
        noise_lsb: 1.5,
        ..PERFECT
    };
    let mut adc = ready(noisy);
    adc.write(CFGR2, 1 | 3 << 2, 100).unwrap();
    let mut sums = Vec::new();
    for scan in 0..2000_u64 {
        adc.write(CR, ADVREGEN | ADSTART, 1000 + scan * 100_000)
            .unwrap();
        run(&mut adc, 1000 + (scan + 1) * 100_000, 2048.3 / 4096.0);
        sums.push(f64::from(adc.read(DR).unwrap()));
    }
    let mean = sums.iter().sum::<f64>() / 2000.0;
    let variance = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / 1999.0;
    // Sum of 16: mean 16 · 2048.3, variance 16 · (1.5² + 1/12).
    assert!((mean - 16.0 * 2048.3).abs() < 0.6, "{mean}");
    let expected = 16.0 * (1.5 * 1.5 + 1.0 / 12.0);
    assert!(
        (variance / expected - 1.0).abs() < 0.15,
        "{variance} instead of {expected}"
    );
}

#[test]
fn gain_and_offset_apply_and_the_code_clips() {
    let off = Imperfection {
        gain_error: 0.01,
        offset_lsb: -3.0,
        noise_lsb: 0.0,
    };
    let code = |fraction: f64| {
        let mut adc = ready(off);
        adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
        run(&mut adc, 10_000, fraction);
        adc.read(DR).unwrap()
    };
    assert_eq!(code(0.5), 2065); // 2048 · 1.01 − 3 = 2065.48
    assert_eq!(code(0.0), 0);
    assert_eq!(code(1.2), 4095);
}

#[test]
fn lower_resolution_is_faster_and_coarser() {
    let mut adc = ready(PERFECT);
    adc.write(CFGR, 2 << 3, 100).unwrap(); // 8 bits
    adc.write(CR, ADVREGEN | ADSTART, 1000).unwrap();
    assert_eq!(adc.next_event(), 1000 + (5 + 17) * 2);
    run(&mut adc, 2000, 0.5);
    assert_eq!(adc.read(DR), Ok(128));
}

#[test]
fn overrun_keeps_the_old_value_and_silences_dma_until_it_is_cleared() {
    let mut adc = ready(PERFECT);
    adc.write(CFGR, 1 | 1 << 1 | ON_TIM6, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
    adc.trigger(13, 1000);
    run(&mut adc, 2000, 0.25);
    assert!(adc.dma_request());
    adc.trigger(13, 3000);
    run(&mut adc, 4000, 0.75);
    assert_eq!(adc.read(ISR).unwrap() & OVR, OVR);
    assert!(!adc.dma_request());
    assert_eq!(adc.read(DR), Ok(1024), "OVRMOD = 0 preserves the data");
    adc.trigger(13, 5000);
    run(&mut adc, 6000, 0.75);
    assert!(!adc.dma_request(), "conversions go on, requests do not");
    adc.write(ISR, OVR | EOC | EOS, 6000).unwrap();
    adc.trigger(13, 7000);
    run(&mut adc, 8000, 0.75);
    assert!(adc.dma_request());
    assert_eq!(adc.read(DR), Ok(3072));
}

#[test]
fn adstp_ends_a_conversion_without_result() {
    let mut adc = ready(PERFECT);
    adc.write(CR, ADVREGEN | ADSTART, 1000).unwrap();
    adc.write(CR, ADVREGEN | ADSTP, 1010).unwrap();
    assert_eq!(adc.read(CR).unwrap() & (ADSTART | ADSTP), 0);
    assert_eq!(adc.next_event(), NEVER);
    assert_eq!(adc.read(ISR).unwrap() & EOC, 0);
}

#[test]
fn configuration_is_locked_while_it_runs() {
    let mut adc = ready(PERFECT);
    adc.write(CFGR, ON_TIM6, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
    assert!(adc.write(CFGR, 0, 200).is_err());
    assert!(adc.write(SQR1, 7 << 6, 200).is_err());
    assert_eq!(adc.read(CFGR), Ok(ON_TIM6));
    assert_eq!(adc.read(SQR1), Ok(0));
    assert!(
        adc.write(DIFSEL, 2, 200).is_err(),
        "DIFSEL is locked while ADEN is set"
    );
    assert_eq!(adc.read(DIFSEL), Ok(0));
}

#[test]
fn common_clock_is_locked_while_a_converter_is_on() {
    let mut common = AdcCommon::default();
    common.write(0x08, 2 << 18, false).unwrap();
    assert_eq!(common.clock(150_000_000, 150_000_000), 37_500_000);
    common.write(0x08, 2 << 18 | 1 << 22, true).unwrap();
    assert!(
        common.vrefint_on(),
        "internal channels may be switched at any time"
    );
    assert!(common.write(0x08, 6 | 2 << 18, true).is_err());
    assert_eq!(
        common.read(0x08).unwrap() & 0x1F,
        0,
        "dual mode was not taken"
    );
    common.write(0x08, 3 << 16, false).unwrap();
    assert_eq!(
        common.clock(0, 150_000_000),
        37_500_000,
        "CKMODE divides the bus clock"
    );
}

/// The sum of sixteen conversions at half of the reference with the factor in use, after switching on at `at`.
fn converted(adc: &mut Adc, at: u64) -> u32 {
    adc.write(CR, ADVREGEN | ADEN, at).unwrap();
    run(adc, at + 1_000, 0.5);
    adc.write(CFGR2, 1 | 3 << 2, at + 1_000).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, at + 1_000).unwrap();
    run(adc, at + 1_000_000, 0.5);
    adc.read(DR).unwrap()
}

/// Calibrates a converter that is off.
fn calibrate(adc: &mut Adc) -> u32 {
    adc.write(CR, ADVREGEN, 0).unwrap();
    adc.write(CR, ADVREGEN | ADCAL, 0).unwrap();
    run(adc, 1_000, 0.0);
    adc.read(CALFACT).unwrap()
}

#[test]
fn a_factor_scatters_by_one_lsb_and_the_codes_with_it_until_it_is_written_back() {
    let mut adc = Adc::new(PERFECT, super::noise());
    adc.set_clock(37_500_000, 150_000_000);
    let first = calibrate(&mut adc);
    assert_eq!(converted(&mut adc, 10_000), 16 * 2_048);
    let mut found = std::collections::BTreeSet::new();
    for _ in 0..40 {
        adc.reset();
        let factor = calibrate(&mut adc);
        found.insert(factor as i32 - 0x40);
        let off = factor as i32 - first as i32;
        assert_eq!(converted(&mut adc, 10_000) as i32, 16 * (2_048 + off));
        adc.write(CALFACT, first, 2_000_000).unwrap();
        adc.write(CR, ADVREGEN | ADSTART, 2_000_000).unwrap();
        run(&mut adc, 3_000_000, 0.5);
        assert_eq!(adc.read(DR), Ok(16 * 2_048));
    }
    assert_eq!(found.into_iter().collect::<Vec<_>>(), [-1, 0, 1]);
}

#[test]
fn a_factor_is_written_only_while_the_converter_is_on_and_does_not_convert() {
    let mut adc = powered(PERFECT);
    assert!(adc.write(CALFACT, 0x41, 0).is_err());
    let mut adc = ready(PERFECT);
    adc.write(CALFACT, 0x41, 100).unwrap();
    assert_eq!(adc.read(CALFACT), Ok(0x41));
    adc.write(CFGR, ON_TIM6, 100).unwrap();
    adc.write(CR, ADVREGEN | ADSTART, 100).unwrap();
    assert!(adc.write(CALFACT, 0x42, 200).is_err());
    assert_eq!(adc.read(CALFACT), Ok(0x41));
}
