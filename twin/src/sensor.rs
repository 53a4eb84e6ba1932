//! The nine inertial sensors: from the true motion at the sensor block to volts.
//!
//! ```text
//! m = n·s                      n: sensitive axis, a unit vector up to 1° off; s: true vector of the triad
//! y'' = Ω²·(g·m + w − y) − 2·ζ·Ω·y'        g: 1 + gain error; w: white noise
//! volts = 1.65 + s_v · clip(y + b + r)     b: bias; r: its random walk; clip at ±105 % of full scale; s_v: V per unit
//! ```
//!
//! The second-order response is stepped exactly for an input that is linear between steps. Noise is drawn once a step:
//! independent values of standard deviation d·√(1/2h), with the step h, have the one-sided density d far below 1/h.
//!
//! "Bandwidth" of the data sheet is the natural frequency Ω/2π. Biases do not depend on temperature.

use std::f64::consts::TAU;

use crate::algebra::Vec3;
use crate::random::Stream;
use crate::sheet::{self, TriadSheet};

/// Time after which the random walk has the size that the data sheet gives, s.
const WALK_TIME_S: f64 = 300.0;

/// True properties of one sensor.
#[derive(Debug, Clone)]
pub struct SensorTruth {
    /// Sensitive axis in body axes, a unit vector.
    pub axis: Vec3,
    /// True over nominal gain.
    pub gain: f64,
    /// Output at zero input and power-on, unit.
    pub bias: f64,
    /// Natural frequency of the response, Hz.
    pub bandwidth_hz: f64,
    /// Damping of the response.
    pub damping: f64,
}

impl SensorTruth {
    /// Draws the sensor on axis 0, 1 or 2 (X, Y, Z) of a triad.
    #[must_use]
    pub fn draw(seed: u64, sheet: &TriadSheet, axis: usize) -> Self {
        let channel = sheet.channels[axis];
        let stream = |quantity: &str| Stream::new(seed, &format!("sensor.{channel}.{quantity}"));
        let [slow, fast] = sheet::BANDWIDTH_HZ;
        let [soft, hard] = sheet::DAMPING;
        Self {
            axis: misaligned(axis, &mut stream("misalignment")),
            gain: 1.0 + stream("gain").within(sheet.gain_tolerance),
            bias: stream("bias").within(sheet.bias_tolerance),
            bandwidth_hz: stream("bandwidth").uniform(slow, fast),
            damping: stream("damping").uniform(soft, hard),
        }
    }
}

/// The unit vector of an axis, tilted by two angles toward the other two.
fn misaligned(axis: usize, stream: &mut Stream) -> Vec3 {
    let (first, second) = loop {
        let [first, second] =
            [stream.normal(), stream.normal()].map(|z| (z * sheet::MISALIGNMENT_DEG).to_radians());
        let largest = sheet::MISALIGNMENT_MAX_DEG.to_radians();
        if first * first + second * second <= largest * largest {
            break (first, second);
        }
    };
    let mut tilted = [0.0; 3];
    tilted[axis] = 1.0;
    tilted[(axis + 1) % 3] = libm::tan(first);
    tilted[(axis + 2) % 3] = libm::tan(second);
    Vec3(tilted) * (1.0 / Vec3(tilted).norm())
}

/// One sensor and its state.
#[derive(Debug, Clone)]
pub struct Sensor {
    truth: SensorTruth,
    volts_per_unit: f64,
    saturation: f64,
    response: Response,
    noise: Stream,
    /// Standard deviation of one step's noise, unit.
    noise_step: f64,
    walk: RandomWalk,
}

impl Sensor {
    /// The sensor on axis 0, 1 or 2 of a triad, settled on the constant input `at_rest` (unit, body axes).
    #[must_use]
    pub fn new(seed: u64, sheet: &TriadSheet, axis: usize, at_rest: Vec3, step_s: f64) -> Self {
        let truth = SensorTruth::draw(seed, sheet, axis);
        let channel = sheet.channels[axis];
        let stream = |quantity: &str| Stream::new(seed, &format!("sensor.{channel}.{quantity}"));
        Self {
            volts_per_unit: sheet.volts_per_unit(),
            saturation: sheet::SATURATION * sheet.full_scale,
            response: Response::new(
                truth.bandwidth_hz,
                truth.damping,
                truth.gain * truth.axis.dot(at_rest),
                step_s,
            ),
            noise: stream("noise"),
            noise_step: sheet.noise_density * (0.5 / step_s).sqrt(),
            walk: RandomWalk::new(stream("walk"), sheet.bias_walk_5min, step_s),
            truth,
        }
    }

    /// Takes the true vector of the triad (unit, body axes) at the end of the next step.
    pub fn advance(&mut self, vector: Vec3) {
        let white = self.noise_step * self.noise.normal();
        let input = self.truth.gain * self.truth.axis.dot(vector) + white;
        self.response.advance(input);
        self.walk.advance();
    }

    /// Output, V.
    #[must_use]
    pub fn volts(&self) -> f64 {
        let value = self.response.output() + self.truth.bias + self.walk.value();
        sheet::ZERO_V + self.volts_per_unit * value.clamp(-self.saturation, self.saturation)
    }
}

/// A random walk that starts at zero.
#[derive(Debug, Clone)]
pub struct RandomWalk {
    stream: Stream,
    step: f64,
    value: f64,
}

impl RandomWalk {
    /// A walk with the standard deviation `after_5min` after 300 s, in steps of `step_s`.
    #[must_use]
    pub fn new(stream: Stream, after_5min: f64, step_s: f64) -> Self {
        Self {
            stream,
            step: after_5min * (step_s / WALK_TIME_S).sqrt(),
            value: 0.0,
        }
    }

    /// Takes one step.
    pub fn advance(&mut self) {
        self.value += self.step * self.stream.normal();
    }

    /// Where the walk is.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }
}

/// A second-order low-pass with gain 1 at zero frequency.
#[derive(Debug, Clone)]
pub struct Response {
    /// Next output and its slope from: output, slope, input now, change of the input.
    step: [[f64; 4]; 2],
    state: [f64; 2],
    input: f64,
}

impl Response {
    /// The response with natural frequency `frequency_hz` and `damping`, settled on a constant input.
    #[must_use]
    pub fn new(frequency_hz: f64, damping: f64, at_rest: f64, step_s: f64) -> Self {
        let omega = TAU * frequency_hz;
        // In units of the step: d/ds of (output, slope, input, change of the input in the step).
        let wh = omega * step_s;
        let rates = [
            [0.0, 1.0, 0.0, 0.0],
            [-wh * wh, -2.0 * damping * wh, wh * wh, 0.0],
            [0.0, 0.0, 0.0, 1.0],
            [0.0; 4],
        ];
        let [output, slope, ..] = exponential(&rates);
        Self {
            step: [output, slope],
            state: [at_rest, 0.0],
            input: at_rest,
        }
    }

    /// Takes the input at the end of the next step; it is linear in between.
    pub fn advance(&mut self, input: f64) {
        let from = [self.state[0], self.state[1], self.input, input - self.input];
        self.state = self
            .step
            .map(|row| row.iter().zip(&from).map(|(a, b)| a * b).sum());
        self.input = input;
    }

    /// The output.
    #[must_use]
    pub fn output(&self) -> f64 {
        self.state[0]
    }
}

/// The exponential of a matrix of norm about 1, by its Taylor series to rounding.
fn exponential(a: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let identity: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    let (mut sum, mut term) = (identity, identity);
    for order in 1..=30 {
        term = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (0..4).map(|k| term[i][k] * a[k][j]).sum::<f64>() / f64::from(order)
            })
        });
        for (row, more) in sum.iter_mut().zip(&term) {
            for (value, part) in row.iter_mut().zip(more) {
                *value += part;
            }
        }
    }
    sum
}
