//! fdl (to come)
