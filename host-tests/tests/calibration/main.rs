//! Zero, truth, gravity, triads and budgets, against motion worked out another way, exact recovery and simulated noise.

mod budget;
mod gravity;
mod noise;
mod triad;
mod truth;
mod zero;
