//! dp (to come)
