//! device (to come)
