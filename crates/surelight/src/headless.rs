//! Keeps Mesa's device-selection layer quiet where there is no desktop.
//!
//! On Linux that Vulkan layer queries the window system for its preferred GPU. Without one (a
//! server, a container) libwayland prints "error: XDG_RUNTIME_DIR is invalid or not set" for each
//! try, which reads as if the render had failed. The layer is switched off by an environment
//! variable, which a program can only set safely for a new program: so this one starts itself again
//! in place.

/// Starts the program again with the layer off, where that is needed. Otherwise, and on failure, it
/// just returns.
pub(crate) fn silence_layers() {
    #[cfg(target_os = "linux")]
    {
        use std::env;
        use std::os::unix::process::CommandExt;

        const LAYER_OFF: &str = "NODEVICE_SELECT";
        if env::var_os("XDG_RUNTIME_DIR").is_some() || env::var_os(LAYER_OFF).is_some() {
            return;
        }
        if let Ok(program) = env::current_exe() {
            // `exec` only returns when it fails, and then there is nothing worse than noise.
            let _failure = std::process::Command::new(program).args(env::args_os().skip(1)).env(LAYER_OFF, "1").exec();
        }
    }
}
