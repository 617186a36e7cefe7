//! pkw (to come)
