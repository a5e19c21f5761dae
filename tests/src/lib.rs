//! Shared helpers of the device tests.
