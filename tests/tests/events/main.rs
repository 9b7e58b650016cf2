//! Events, sensors and the list of moved bodies.

mod bits;
mod hits;
mod kinds;
mod moved;
mod oracle;
mod scene;
mod sensors;
