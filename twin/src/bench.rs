//! The whole bench: motion base, sensors and cables, in steps of half a millisecond.
//!
//! A bench knows no socket. Its owner gives it programs, takes rows of voltages and can watch the truth of each step.

use thiserror::Error;

use crate::algebra::Vec3;
use crate::board::{BoardTruth, COLUMNS, Surroundings};
use crate::controller::{Controller, Refusal};
use crate::geometry::{Geometry, GeometryError};
use crate::jack::{JackMotion, Jacks};
use crate::mechanism::{Linearised, Mechanism, MechanismError, Pose, Twist};
use crate::motion::{Felt, Motion, Place};
use crate::program::Program;
use crate::sensor::Sensor;
use crate::sheet::TRIADS;
use crate::transducer::Transducer;
use crate::truth;
use crate::vibration::Vibration;

/// Time between rows, s.
pub const STEP_S: f64 = 0.0005;
/// Steps in a chunk; a chunk has one row more.
pub const CHUNK_STEPS: usize = 40;

const AT_REST: Twist = Twist {
    linear: Vec3::ZERO,
    angular: Vec3::ZERO,
};

/// One voltage row: [`COLUMNS`].
pub type Row = [f32; COLUMNS.len()];

/// Why a bench cannot be set up or go on.
#[derive(Debug, Error)]
pub enum BenchError {
    /// The geometry is no good.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// The platform cannot follow its jacks.
    #[error("at {time_s:.4} s: {source}")]
    Mechanism {
        /// True time since the start, s.
        time_s: f64,
        /// Why.
        source: MechanismError,
    },
}

/// A motion base with its sensors, drawn from a seed.
#[derive(Debug, Clone)]
pub struct Bench {
    step_s: f64,
    board: BoardTruth,
    surroundings: Surroundings,
    mid_length_m: f64,
    /// True hinges, and the mechanism at the last pose.
    mechanism: Mechanism,
    linearised: Linearised,
    place: Place,
    controller: Controller,
    jacks: Jacks,
    vibration: Vibration,
    sensors: [Sensor; 9],
    transducers: [Transducer; 6],
    /// Steps since the start, and when the board was connected.
    step: u64,
    connected_at: u64,
    motion: Motion,
    row: Row,
}

impl Bench {
    /// A bench with the base of a geometry file (its text), at rest at home.
    ///
    /// # Errors
    /// [`BenchError::Geometry`] for a text that is no usable geometry.
    pub fn new(seed: u64, geometry_toml: &str) -> Result<Self, BenchError> {
        Self::with_geometry(seed, &Geometry::parse(geometry_toml)?)
    }

    /// A bench with this base, at rest at home: the true jacks have the lengths of the nominal home.
    ///
    /// # Errors
    /// [`BenchError::Mechanism`] if the true hinges do not allow that.
    pub fn with_geometry(seed: u64, geometry: &Geometry) -> Result<Self, BenchError> {
        Self::with_step(seed, geometry, STEP_S)
    }

    /// A bench with steps of `step_s` instead of [`STEP_S`]. It has the same truth and other noise. For steps up to a
    /// millisecond, its motion is the same to a micrometre.
    ///
    /// # Errors
    /// [`BenchError::Mechanism`] if the true hinges do not allow the home pose.
    pub fn with_step(seed: u64, geometry: &Geometry, step_s: f64) -> Result<Self, BenchError> {
        let mechanism = geometry.true_mechanism(seed);
        let place = Place {
            lever_arm_m: truth::lever_arm_m(seed),
            gravity_m_s2: truth::gravity_m_s2(seed),
        };
        let home_m = geometry.home_displacements_m();
        let at_start = |source| BenchError::Mechanism {
            time_s: 0.0,
            source,
        };
        let pose = mechanism
            .solve_pose(&geometry.nominal.lengths(&geometry.home), geometry.home)
            .map_err(at_start)?;
        let linearised = mechanism.linearised(&pose).map_err(at_start)?;
        let felt = Felt::at(&pose, &AT_REST, &AT_REST, &place);
        let at_rest = felt.triads();
        let mut bench = Self {
            step_s,
            board: BoardTruth::draw(seed),
            surroundings: Surroundings::draw(seed),
            mid_length_m: geometry.mid_length_m(),
            vibration: Vibration::draw(seed, &mechanism, &pose, place.lever_arm_m),
            mechanism,
            linearised,
            place,
            controller: Controller::draw(seed, geometry),
            jacks: Jacks::draw(seed, home_m),
            sensors: std::array::from_fn(|k| {
                Sensor::new(seed, &TRIADS[k / 3], k % 3, at_rest[k / 3], step_s)
            }),
            transducers: std::array::from_fn(|k| Transducer::draw(seed, k, geometry.stroke_m())),
            step: 0,
            connected_at: 0,
            motion: Motion {
                time_s: 0.0,
                jacks: JackMotion {
                    displacement_m: home_m,
                    ..JackMotion::default()
                },
                pose,
                velocity: AT_REST,
                acceleration: AT_REST,
                felt,
            },
            row: [0.0; COLUMNS.len()],
        };
        bench.read_row();
        Ok(bench)
    }

    /// What the twin tells a board about itself.
    #[must_use]
    pub fn board(&self) -> &BoardTruth {
        &self.board
    }

    /// The truth of this moment.
    #[must_use]
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Connects a board: its time begins now.
    pub fn connect(&mut self) {
        self.connected_at = self.step;
        self.motion.time_s = 0.0;
    }

    /// Gives the controller a program; the run starts 0 to 10 s later.
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves.
    pub fn run(&mut self, name: &str, program: Program) -> Result<(), Refusal> {
        self.controller.run(name, program, self.time_s())
    }

    /// Whether a run is under way or waits for its start.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.controller.occupation(self.time_s()).is_some()
    }

    /// Stops the base; it returns home.
    pub fn stop(&mut self) {
        self.controller.stop(self.time_s());
    }

    /// Makes the next chunk: [`CHUNK_STEPS`] + 1 rows of [`COLUMNS`] one after another. The first row repeats the last
    /// row of the chunk before. `watch` gets the truth of each step.
    ///
    /// # Errors
    /// [`BenchError::Mechanism`] if the platform cannot follow its jacks; the bench cannot be used any more.
    pub fn next_chunk(
        &mut self,
        rows: &mut Vec<f32>,
        mut watch: impl FnMut(&Motion),
    ) -> Result<(), BenchError> {
        rows.clear();
        rows.extend_from_slice(&self.row);
        for _ in 0..CHUNK_STEPS {
            self.advance().map_err(|source| BenchError::Mechanism {
                time_s: self.time_s(),
                source,
            })?;
            watch(&self.motion);
            rows.extend_from_slice(&self.row);
        }
        Ok(())
    }

    /// True time since the start, s.
    fn time_s(&self) -> f64 {
        self.step as f64 * self.step_s
    }

    fn advance(&mut self) -> Result<(), MechanismError> {
        self.vibration
            .advance(&self.motion.jacks.speed_m_s, self.step_s);
        self.jacks
            .advance(&self.controller, self.time_s(), self.step_s);
        self.step += 1;
        self.follow_jacks()?;
        let felt = self.motion.felt.triads();
        for (k, sensor) in self.sensors.iter_mut().enumerate() {
            sensor.advance(felt[k / 3]);
        }
        self.read_row();
        Ok(())
    }

    /// Finds the motion of the platform from that of the jacks.
    fn follow_jacks(&mut self) -> Result<(), MechanismError> {
        let time_s = self.time_s();
        let servos = self.jacks.motion();
        let jacks = self.vibration.added_to(&servos, time_s);
        let lengths = jacks.displacement_m.map(|x| self.mid_length_m + x);
        let (pose, linearised) =
            self.mechanism
                .follow(&lengths, self.expected_pose(), &self.linearised)?;
        let velocity = linearised.velocity(&jacks.speed_m_s);
        let acceleration =
            linearised.acceleration(&velocity, &jacks.speed_m_s, &jacks.acceleration_m_s2);
        self.linearised = linearised;
        self.motion = Motion {
            time_s: (self.step - self.connected_at) as f64 * self.step_s,
            jacks,
            pose,
            velocity,
            acceleration,
            felt: Felt::at(&pose, &velocity, &acceleration, &self.place),
        };
        Ok(())
    }

    /// The pose one step later, at the acceleration of the last step.
    fn expected_pose(&self) -> Pose {
        let h = self.step_s;
        let ahead =
            |velocity: Vec3, acceleration: Vec3| velocity * h + acceleration * (0.5 * h * h);
        let Motion {
            pose,
            velocity,
            acceleration,
            ..
        } = &self.motion;
        pose.moved(Twist {
            linear: ahead(velocity.linear, acceleration.linear),
            angular: ahead(velocity.angular, acceleration.angular),
        })
    }

    /// Reads all voltages of this moment.
    fn read_row(&mut self) {
        let time_s = self.time_s();
        let hum_v = self.surroundings.hum_v(time_s);
        let (pins, others) = self.row.split_at_mut(15);
        let (inertial, jacks) = pins.split_at_mut(9);
        for (pin, sensor) in inertial.iter_mut().zip(&self.sensors) {
            *pin = (sensor.volts() + hum_v) as f32;
        }
        let displacements = self.motion.jacks.displacement_m;
        for ((pin, transducer), x) in jacks
            .iter_mut()
            .zip(&mut self.transducers)
            .zip(displacements)
        {
            *pin = (transducer.volts(x) + hum_v) as f32;
        }
        others[0] = self.surroundings.temperature_c(time_s) as f32;
        others[1] = self.surroundings.supply_v(time_s) as f32;
    }
}
