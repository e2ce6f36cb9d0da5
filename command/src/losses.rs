//! What friction takes of a mesh cycle, for `gearmesh solve`.

use clap::Args;
use gearmesh::friction::{Loss, Sliding, loss_factor_of, ohlendorf};
use gearmesh::pair::Pair;
use gearmesh::words::rounded;
use gearmesh_preprocessor::contact::{CycleInput, MeshCycle};
use serde::Serialize;

use crate::limits;
use crate::output::{Listing, rows};

/// Speeds at which losses are asked for.
#[derive(Debug, Clone, Args)]
pub struct SpeedArgs {
    /// Speeds of gear 1 at which loss and efficiency are wanted, rpm, separated by commas
    #[arg(long, value_delimiter = ',')]
    speed_rpm: Vec<f64>,
}

/// Losses of a mesh cycle; lists run over the speeds.
#[derive(Debug, Serialize)]
pub struct Losses {
    /// Loss over transmitted power at a coefficient of 1, by the share of the load.
    loss_factor: f64,
    /// The same for tooth pairs that share the load evenly (Ohlendorf).
    loss_factor_ohlendorf: f64,
    speed_rpm: Vec<f64>,
    /// Mean over the cycle, weighted with load times sliding: times `loss_factor` and the transmitted power it is `loss_w`.
    friction_coefficient: Vec<f64>,
    loss_w: Vec<f64>,
    efficiency: Vec<f64>,
}

impl Losses {
    /// Of `cycle`.
    ///
    /// # Errors
    /// Speeds that no gear has.
    pub fn new(
        pair: &Pair,
        input: &CycleInput,
        cycle: &MeshCycle,
        speeds: &SpeedArgs,
    ) -> Result<Losses, crate::Error> {
        let g = &pair.geometry;
        let mut losses = Losses {
            loss_factor: loss_factor_of(g, Sliding::mean(&cycle.sliding).distance),
            loss_factor_ohlendorf: ohlendorf(g, g.center_distance + input.center_distance_offset),
            speed_rpm: speeds.speed_rpm.clone(),
            friction_coefficient: vec![],
            loss_w: vec![],
            efficiency: vec![],
        };
        for &speed in &speeds.speed_rpm {
            limits::within("speed-rpm", speed, 0.0..=1e6)?;
            let spin = speed * std::f64::consts::TAU / 60.0;
            let sliding = [&cycle.sliding[..], &cycle.friction];
            let loss = Loss::new(g, &pair.friction, sliding, input.torque, spin);
            losses.friction_coefficient.push(loss.coefficient);
            losses.loss_w.push(loss.power);
            losses.efficiency.push(loss.efficiency);
        }
        Ok(losses)
    }

    /// Adds them to a listing.
    pub fn list(&self, rows: &mut Listing) {
        rows! { rows;
            "loss factor by the load share" => "{:.4}", self.loss_factor;
            "loss factor of Ohlendorf" => "{:.4}", self.loss_factor_ohlendorf;
        }
        for (i, speed) in self.speed_rpm.iter().enumerate() {
            let percent = 100.0 * self.efficiency[i];
            rows! { rows;
                format!("loss at {} rpm", rounded(*speed)) =>
                    "{:.2} W, efficiency {percent:.3} %, mean coefficient of friction {:.4}",
                    self.loss_w[i], self.friction_coefficient[i];
            }
        }
    }
}
