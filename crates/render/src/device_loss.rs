//! Loss of the device: the driver drops it, or reports an error outside of every error scope.
//!
//! wgpu reports either by a callback at any time. It is noted here, and every call that waits for
//! the device or submits to it fails with [`RenderError::DeviceLost`] from then on: a render stops,
//! keeps its checkpoint, and writes no image of lost work.

use std::sync::{Arc, Mutex};

use crate::error::RenderError;

/// Records that a device was lost.
pub(crate) struct LossWatch {
    message: Arc<Mutex<Option<String>>>,
}

impl LossWatch {
    /// Watches a device from here on.
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        let message = Arc::new(Mutex::new(None));
        let note = |sink: &Mutex<Option<String>>, text: String| {
            *sink.lock().unwrap_or_else(|e| e.into_inner()) = Some(text);
        };
        let sink = message.clone();
        device.set_device_lost_callback(move |_, text| note(&sink, text));
        let sink = message.clone();
        // Without a handler an uncaptured error panics. Every call is in an error scope, so this is
        // a last resort.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&sink, error.to_string())));
        Self { message }
    }

    /// An error once the device is lost. `adapter`: its name, for the message.
    pub(crate) fn check(&self, adapter: &str) -> Result<(), RenderError> {
        match self.message.lock().unwrap_or_else(|e| e.into_inner()).as_ref() {
            Some(message) => Err(RenderError::DeviceLost { adapter: adapter.into(), message: message.clone() }),
            None => Ok(()),
        }
    }
}
