//! profirust as DP master over our links (to come)
