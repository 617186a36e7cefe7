//! ppo (to come)
