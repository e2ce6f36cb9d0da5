//! Tables against the contact solver where it is hardest: beyond the ends of their ranges, under loads that are small, and on bodies that turn.

pub mod bodies;
pub mod edges;
pub mod pairs;
