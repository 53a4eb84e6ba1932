//! What is taken for granted, and how far each of it may be off.
//!
//! An estimate stands on the geometry file, the sensor file and the data sheet of the board. Each number there has a
//! tolerance; [`Belief::doubts`] lists beliefs with one number changed by its standard uncertainty, so that repeating
//! the estimate under each shows what that doubt does to every result (GUM 5.1.3, note 2).

use hexsense_core::calibration::budget::{Cause, Shape, uniform};
use hexsense_core::calibration::truth::Site;
use hexsense_core::channel::JACKS;
use hexsense_core::facts::BoardFacts;
use hexsense_core::kinematics::{Geometry, GeometryError};
use hexsense_core::records::JackCoefficients;
use nalgebra::Vector3;

use crate::geometry_file::GeometryFile;
use crate::sensor_file::SensorFile;

/// Everything that turns counts into lengths and poses into truth.
#[derive(Debug, Clone)]
pub struct Belief {
    lower: [Vector3<f64>; JACKS],
    upper: [Vector3<f64>; JACKS],
    length_min_m: f64,
    length_max_m: f64,
    home_height_m: f64,
    /// Counts at mid-stroke.
    zero_counts: [f64; JACKS],
    /// Change of length per count, m.
    metres_per_count: [f64; JACKS],
    /// True counts at nominal supply per believed one.
    pub supply: f64,
    /// True time per believed time.
    pub clock: f64,
    /// Lever arm and gravity.
    pub site: Site,
    /// The board that the counts come from.
    pub board: BoardFacts,
}

/// A belief with one number changed by its standard uncertainty.
#[derive(Debug, Clone)]
pub struct Doubt {
    /// What was changed.
    pub cause: Cause,
    /// How that is distributed.
    pub shape: Shape,
    /// The changed belief.
    pub belief: Belief,
}

impl Belief {
    /// What the files say.
    #[must_use]
    pub fn new(base: &GeometryFile, sensors: &SensorFile) -> Self {
        let geometry = &base.geometry;
        let stroke_m = geometry.length_max_m() - geometry.length_min_m();
        let counts_per_volt = sensors.counts_per_volt();
        Self {
            lower: *geometry.lower(),
            upper: *geometry.upper(),
            length_min_m: geometry.length_min_m(),
            length_max_m: geometry.length_max_m(),
            home_height_m: geometry.home_height_m(),
            zero_counts: [sensors.jacks.zero_volts * counts_per_volt; JACKS],
            metres_per_count: [stroke_m / sensors.jacks.full_stroke_volts / counts_per_volt; JACKS],
            supply: 1.0,
            clock: 1.0,
            site: Site {
                lever_arm_m: Vector3::from(sensors.lever_arm_m),
                gravity_m_s2: sensors.gravity.m_s2,
            },
            board: sensors.board,
        }
    }

    /// The geometry under this belief.
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
        let mid_m = (self.length_min_m + self.length_max_m) / 2.0;
        core::array::from_fn(|jack| {
            mid_m
                + (counts[jack] * self.supply - self.zero_counts[jack])
                    * self.metres_per_count[jack]
        })
    }

    /// The transducers as a coefficient set carries them, so that the board believes the same of them.
    #[must_use]
    pub fn jack_coefficients(&self) -> JackCoefficients {
        JackCoefficients {
            zero_length_m: ((self.length_min_m + self.length_max_m) / 2.0) as f32,
            zero_counts: self.zero_counts.map(|counts| counts as f32),
            metres_per_count: self.metres_per_count.map(|metres| metres as f32),
        }
    }

    /// All doubts: hinges, jack gains and offsets, converters, supply, clock, lever arm and gravity.
    #[must_use]
    pub fn doubts(&self, base: &GeometryFile, sensors: &SensorFile) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        let mut doubt = |cause, shape, change: &dyn Fn(&mut Self)| {
            let mut belief = self.clone();
            change(&mut belief);
            doubts.push(Doubt {
                cause,
                shape,
                belief,
            });
        };
        for jack in 0..JACKS {
            for axis in 0..3 {
                let tolerance_m = base.hinge_tolerance_m;
                doubt(Cause::Hinges, Shape::Normal, &|belief| {
                    belief.lower[jack][axis] += tolerance_m
                });
                doubt(Cause::Hinges, Shape::Normal, &|belief| {
                    belief.upper[jack][axis] += tolerance_m
                });
            }
        }
        let gravity_m_s2 = sensors.gravity.uncertainty_m_s2;
        doubt(Cause::Gravity, Shape::Normal, &|belief| {
            belief.site.gravity_m_s2 += gravity_m_s2
        });
        let mut tolerance =
            |cause, change: &dyn Fn(&mut Self)| doubt(cause, Shape::Uniform, change);
        self.doubt_jacks(sensors, &mut tolerance);
        self.doubt_board(sensors, &mut tolerance);
        let arm_m = uniform(sensors.lever_arm_tolerance_m);
        for axis in 0..3 {
            tolerance(Cause::LeverArm, &|belief| {
                belief.site.lever_arm_m[axis] += arm_m
            });
        }
        doubts
    }

    /// Transducers, and the converter that reads them.
    fn doubt_jacks(&self, sensors: &SensorFile, tolerance: Tolerance) {
        let (jacks, adc) = (&sensors.jacks, &sensors.adc);
        let gain = 1.0 + uniform(jacks.gain_tolerance);
        for jack in 0..JACKS {
            let offset = uniform(jacks.offset_tolerance_m) / self.metres_per_count[jack];
            tolerance(Cause::JackGain, &|belief| {
                belief.metres_per_count[jack] *= gain
            });
            tolerance(Cause::JackOffset, &|belief| {
                belief.zero_counts[jack] += offset
            });
        }
        // The gain of a converter turns about zero counts, not about mid-stroke.
        let gain = 1.0 + uniform(adc.gain_tolerance);
        tolerance(Cause::JackConverter, &|belief| {
            belief
                .metres_per_count
                .iter_mut()
                .for_each(|metres| *metres *= gain);
            belief.zero_counts.iter_mut().for_each(|zero| *zero /= gain);
        });
        let offset = uniform(adc.offset_tolerance_lsb) * COUNTS_PER_CODE;
        tolerance(Cause::JackConverter, &|belief| {
            belief
                .zero_counts
                .iter_mut()
                .for_each(|zero| *zero += offset)
        });
    }

    /// Supply and clock of the board. The supply is measured through the reference: its converter's gain and offset
    /// and the rounding of the factory's reading all enter.
    fn doubt_board(&self, sensors: &SensorFile, tolerance: Tolerance) {
        let adc = &sensors.adc;
        for relative in [
            adc.gain_tolerance,
            adc.offset_tolerance_lsb / REFERENCE_CODE,
            0.5 / FACTORY_CODE,
        ] {
            tolerance(Cause::SupplyReference, &|belief| {
                belief.supply *= 1.0 + uniform(relative)
            });
        }
        let clock = uniform(adc.clock_tolerance_ppm * 1e-6);
        tolerance(Cause::Clock, &|belief| belief.clock *= 1.0 + clock);
    }
}

/// Takes a cause and what its tolerance changes.
type Tolerance<'a> = &'a mut dyn FnMut(Cause, &dyn Fn(&mut Belief));

/// Code of the internal reference, about 1.21 V, at 3.3 V and at the factory's 3.0 V.
const REFERENCE_CODE: f64 = 1_504.0;
const FACTORY_CODE: f64 = 1_655.0;
/// Conversions that the board adds up into a count.
const COUNTS_PER_CODE: f64 = 16.0;
