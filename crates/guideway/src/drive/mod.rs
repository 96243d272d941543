//! Driving: a plant, a controller, and the loop between them.
