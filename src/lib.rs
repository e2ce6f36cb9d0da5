//! gearmesh: the gear contact element that any simulator can load.
//!
//! An FMU (FMI 2.0) takes the poses and velocities of two meshing gears and returns contact force,
//! moment and contact point. Behind it stand tables of static transmission error and shuttling
//! that `gearmesh-preprocessor` computes by three-dimensional static tooth contact, after Palermo, Mundo, Hadjit,
//! Desmet (2013), "Multibody element for spur and helical gear meshing based on detailed
//! three-dimensional contact calculations", Mechanism and Machine Theory 62, 13-30.
//!
//! # How the data flow
//!
//! ```text
//!  pair file ──> pair ──> compliance ──> contact ──> sweep ──> tables.json (FMU resources)
//!  (drawing)              of teeth       static                     │
//!                         and bodies     solve                      v
//!                                                             table, contact
//!                                                                   │
//!                     poses, velocities ─────────> element <────────┘
//!                     (FMI inputs)                    │
//!                                                     v
//!                                        force, moment, contact point
//! ```
//!
//! This crate is the FMU's library: what runs in an FMU, `gear`, `friction`, `contact`, evaluation of tables, `element` and `fmi`. The law of
//! a flank (`element::law`) is a table, a constant stiffness, tooth pairs one by one, or a contact solve at every evaluation. What prepares it
//! is `gearmesh-preprocessor`, which depends on this crate: pair files, generated teeth, finite elements, static contact with its pressures, the
//! sweep of tables and packing; `gearmesh-command` is the program over both.
//!
//! # Symbols
//!
//! SI inside; millimetres, micrometres and degrees only in pair files and printed output, with the
//! unit in the name.
//!
//! | symbol | code | unit | meaning, equation of the paper |
//! |---|---|---|---|
//! | e | `e()` | 1 | +1 external, -1 internal pair |
//! | s | `flank.sign()` | 1 | loaded flank, +1: gear 1 pushes in its +theta sense (drive) |
//! | h | `hand` | 1 | +1 right-handed, -1 left-handed gear |
//! | kappa | `kappa()` | 1 | +1 external teeth, -1 ring |
//! | C | `center_distance` | m | distance of the axes in the transverse plane, (14) |
//! | phi | `operating_pressure_angle()` | rad | transverse, cos phi = abs(rb1 + e rb2) / C, (15) |
//! | rb | `base_radius()` | m | base radius |
//! | r_w | `operating_pitch_radius()` | m | z C / abs(z1 + e z2), (3) |
//! | beta_b | `base_helix_angle()` | rad | tan beta_b = tan beta cos alpha_t |
//! | DTE | `transmission_error` | m | dynamic transmission error, tangential, (1) |
//! | delta | `delta` | m | approach on the line of action at mid-face, DTE cos phi |
//! | STE | `approach` | m | static transmission error on the line of action at mid-face |
//! | PMC | `mesh_position` | 1 | position on the mesh cycle, (13) |
//! | M | `misalignment` | rad | in the plane of action, > 0: more penetration at larger z, (18) |
//! | F_tt | `tangential_force` | N | transverse tangential force at the pitch circle, (8) |
//! | F_bt | `loa_force` | N | transverse force on the line of action, F_tt / cos phi |
//! | y | `contact_line()` | m | along the path of contact from the pitch point, in the sense of the force on gear 2 |
//! | sigma | `lean` | 1 | dy/dz of the contact lines in the plane of action, s h tan beta_b |
//! | z_c | `contact_z` | m | axial position where the resultant crosses the pitch plane y = 0, (26) |
//! | z_ref | `z_ref()` | m | mid-face of the overlap, reference of delta, M and z_c |
//! | W | `energy`, `value` | J | potential of one flank: F_bt = dW/d delta, F_bt (z_c - z_ref) = dW/dM |

pub mod accuracy;
pub mod contact;
pub mod element;
pub mod fmi;
pub mod friction;
pub mod gear;
pub mod random;
pub mod root;
pub mod sealed;
pub mod table;
pub mod vector;
pub mod words;
// Test code that is shared with tests/ names the library.
#[cfg(test)]
extern crate self as gearmesh;
