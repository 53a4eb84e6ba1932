//! What the analysis assumes, and how far each assumption may be off.
//!
//! An estimate stands on the geometry file, the sensor file and the data sheet of the board. Each number there has a
//! tolerance. [`Assumptions::perturbations`] lists the assumptions with one number changed by its standard uncertainty.
//! The estimate is repeated with each of them, which shows how sensitive every result is to that number (GUM 5.1.3,
//! note 2).

use hexsense_core::calibration::budget::{Cause, Distribution, uniform};
use hexsense_core::calibration::truth::Site;
use hexsense_core::channel::{INERTIAL, JACKS, Ratiometric};
use hexsense_core::facts::BoardFacts;
use hexsense_core::kinematics::{Geometry, GeometryError};
use hexsense_core::records::JackCoefficients;
use hexsense_core::transducers::Transducers;
use nalgebra::Vector3;

use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Everything that turns counts into lengths, and poses into truth.
#[derive(Debug, Clone)]
pub struct Assumptions {
    lower: [Vector3<f64>; JACKS],
    upper: [Vector3<f64>; JACKS],
    length_min_m: f64,
    length_max_m: f64,
    home_height_m: f64,
    transducers: Transducers<f64>,
    /// True counts at nominal supply over assumed ones.
    pub supply: f64,
    /// True time over assumed time.
    pub clock: f64,
    /// Lever arm and gravity.
    pub site: Site,
    /// The board that the counts come from.
    pub board: BoardFacts,
    ratiometric: Ratiometric,
}

/// Assumptions with one number changed by its standard uncertainty.
#[derive(Debug, Clone)]
pub struct Perturbation {
    /// What was changed.
    pub cause: Cause,
    /// How that is distributed.
    pub shape: Distribution,
    /// The changed assumptions.
    pub assumptions: Assumptions,
}

impl Assumptions {
    /// What the files say.
    #[must_use]
    pub fn new(base: &GeometryFile, sensors: &SensorFile) -> Self {
        let geometry = &base.geometry;
        Self {
            lower: *geometry.lower(),
            upper: *geometry.upper(),
            length_min_m: geometry.length_min_m(),
            length_max_m: geometry.length_max_m(),
            home_height_m: geometry.home_height_m(),
            transducers: sensors.transducers(geometry),
            supply: 1.0,
            clock: 1.0,
            site: sensors.site(),
            board: sensors.board,
            ratiometric: sensors.ratiometric(),
        }
    }

    /// The assumed geometry.
    ///
    /// # Errors
    /// [`GeometryError`] when the changed numbers make no motion base.
    pub fn geometry(&self) -> Result<Geometry<f64>, GeometryError<f64>> {
        Geometry::new(
            self.lower,
            self.upper,
            self.length_min_m,
            self.length_max_m,
            Some(self.home_height_m),
        )
    }

    /// Jack lengths, m, from counts at nominal supply.
    #[must_use]
    pub fn lengths_m(&self, counts: &[f64; JACKS]) -> [f64; JACKS] {
        let true_counts =
            core::array::from_fn(|jack| counts[jack] * self.supply_of(INERTIAL + jack));
        self.transducers.lengths_m(&true_counts)
    }

    /// True counts at nominal supply over assumed ones of a channel: the supply does not act on a ratiometric one.
    #[must_use]
    pub fn supply_of(&self, channel: usize) -> f64 {
        if self.ratiometric.has(channel) {
            1.0
        } else {
            self.supply
        }
    }

    /// The transducers as a coefficient set carries them, so that the board assumes the same.
    #[must_use]
    pub fn jack_coefficients(&self) -> JackCoefficients {
        let Transducers {
            zero_length_m,
            zero_counts,
            metres_per_count,
            ..
        } = self.transducers;
        JackCoefficients {
            zero_length_m: zero_length_m as f32,
            zero_counts: zero_counts.map(|counts| counts as f32),
            metres_per_count: metres_per_count.map(|metres| metres as f32),
        }
    }

    /// All perturbations: hinges, jack gains and offsets, converters, supply, clock, lever arm and gravity.
    #[must_use]
    pub fn perturbations(&self, base: &GeometryFile, sensors: &SensorFile) -> Vec<Perturbation> {
        let mut perturbations = Vec::new();
        let mut perturb = |cause, shape, change: &dyn Fn(&mut Self)| {
            let mut assumptions = self.clone();
            change(&mut assumptions);
            perturbations.push(Perturbation {
                cause,
                shape,
                assumptions,
            });
        };
        for jack in 0..JACKS {
            for axis in 0..3 {
                let tolerance_m = base.hinge_tolerance_m;
                perturb(Cause::Hinges, Distribution::Normal, &|assumptions| {
                    assumptions.lower[jack][axis] += tolerance_m
                });
                perturb(Cause::Hinges, Distribution::Normal, &|assumptions| {
                    assumptions.upper[jack][axis] += tolerance_m
                });
            }
        }
        let gravity_m_s2 = sensors.gravity.uncertainty_m_s2;
        perturb(Cause::Gravity, Distribution::Normal, &|assumptions| {
            assumptions.site.gravity_m_s2 += gravity_m_s2
        });
        let mut tolerance =
            |cause, change: &dyn Fn(&mut Self)| perturb(cause, Distribution::Uniform, change);
        self.perturb_jacks(sensors, &mut tolerance);
        perturb_board(sensors, &mut tolerance);
        let arm_m = uniform(sensors.lever_arm_tolerance_m);
        for axis in 0..3 {
            tolerance(Cause::LeverArm, &|assumptions| {
                assumptions.site.lever_arm_m[axis] += arm_m
            });
        }
        perturbations
    }

    /// Transducers, and the converter that reads them.
    fn perturb_jacks(&self, sensors: &SensorFile, tolerance: Tolerance) {
        let (jacks, adc) = (&sensors.jacks, &sensors.adc);
        let gain = 1.0 + uniform(jacks.gain_tolerance);
        for jack in 0..JACKS {
            let offset =
                uniform(jacks.offset_tolerance_m) / self.transducers.metres_per_count[jack];
            tolerance(Cause::JackGain, &|assumptions| {
                assumptions.transducers.metres_per_count[jack] *= gain
            });
            tolerance(Cause::JackOffset, &|assumptions| {
                assumptions.transducers.zero_counts[jack] += offset
            });
        }
        // The gain of a converter turns about zero counts, not about mid-stroke.
        let gain = 1.0 + uniform(adc.gain_tolerance);
        tolerance(Cause::JackConverter, &|assumptions| {
            let transducers = &mut assumptions.transducers;
            let metres = transducers.metres_per_count.iter_mut();
            metres.for_each(|metres| *metres *= gain);
            let zeros = transducers.zero_counts.iter_mut();
            zeros.for_each(|zero| *zero /= gain);
        });
        let offset = uniform(adc.offset_tolerance_lsb) * COUNTS_PER_CODE;
        tolerance(Cause::JackConverter, &|assumptions| {
            let zeros = assumptions.transducers.zero_counts.iter_mut();
            zeros.for_each(|zero| *zero += offset)
        });
    }
}

/// Supply and clock of the board. The supply is measured through the reference: its converter's gain and offset and
/// the rounding of the factory's reading all enter.
fn perturb_board(sensors: &SensorFile, tolerance: Tolerance) {
    let adc = &sensors.adc;
    for relative in [
        adc.gain_tolerance,
        adc.offset_tolerance_lsb / REFERENCE_CODE,
        0.5 / FACTORY_CODE,
    ] {
        tolerance(Cause::SupplyReference, &|assumptions| {
            assumptions.supply *= 1.0 + uniform(relative)
        });
    }
    let clock = uniform(adc.clock_tolerance_ppm * 1e-6);
    tolerance(Cause::Clock, &|assumptions| {
        assumptions.clock *= 1.0 + clock
    });
}

/// Takes a cause and what its tolerance changes.
type Tolerance<'a> = &'a mut dyn FnMut(Cause, &dyn Fn(&mut Assumptions));

/// Code of the internal reference, about 1.21 V, at 3.3 V and at the factory's 3.0 V.
const REFERENCE_CODE: f64 = 1_504.0;
const FACTORY_CODE: f64 = 1_655.0;
/// Counts of one code of the converter: the board adds up so many conversions.
pub const COUNTS_PER_CODE: f64 = 16.0;
