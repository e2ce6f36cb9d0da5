//! Tables against the contact solver where it is hardest: beyond the ends of their ranges, and under loads that are small.

pub mod edges;
pub mod pairs;
